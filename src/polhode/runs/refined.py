"""When a run is refined: double corrected by exact arithmetic, where that serves and is faster."""

from __future__ import annotations

import math

from polhode.equations import readout
from polhode.numbers.number_types import NumberType
from polhode.runs.options import Options
from polhode.scenes.scene import Scene

#: Forms whose variables are linear functions of the principal one's.  Gauss collocation gives the
#: same states in each of them, so it is done in principal axes.
LINEAR = ("principal", "general", "inertia-axes", "momentum", "gyration-axes")

_MOST_LOG10_ANGLE = 12  # beyond it no run ends
#: Radians turned from which on refinement is the faster way: from 10 on once what is compiled is
#: loaded, from 80 on in a process that has to load it.
_LEAST_ANGLE = 20.0
_LEAST_ANGLE_MP = 120.0  # for more limbs than quad's, whose field takes seconds to compile once


def hindrance(scene: Scene, number: NumberType, options: Options) -> str | None:
    """What would have to be otherwise for such a run to be refined; None where nothing has."""
    if number.bits <= 64:
        return "quad or more digits"
    from polhode.refined.refinement import MOST_DIGITS

    if int(number.most_digits) > MOST_DIGITS:
        return f"at most {MOST_DIGITS} digits"
    if scene.form not in LINEAR:
        return "one of the forms " + ", ".join(LINEAR)
    if "angles" in scene.modelled and scene.starts_at_pole:
        return "no angles of a motion that starts at a pole"
    if scene.events:
        return "no events"
    if options.tolerance is not None or options.inputs is not None or options.project:
        return "no tolerance, rounded inputs or projection of its own"
    if scene.log10_angle > _MOST_LOG10_ANGLE:
        return f"a motion of at most 10**{_MOST_LOG10_ANGLE} radians"
    if readout.at_rest(scene).state:
        return "a motion that does not stand still"
    return None


def worth_it(scene: Scene, number: NumberType) -> bool:
    """Whether a run is long enough for refinement to be the faster way."""
    least = _LEAST_ANGLE if int(number.most_digits) <= 34 else _LEAST_ANGLE_MP
    return bool(scene.log10_angle >= math.log10(least))
