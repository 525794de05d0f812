"""How a run is to be made, checked where it is asked for: number type, times, tolerance, method."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from polhode.common.arguments import of_kind, steps, whole
from polhode.common.errors import BadInput, nearest, plain
from polhode.equations import readout
from polhode.numbers import number_types
from polhode.numbers.conversion import exact_number
from polhode.numbers.number_types import DOUBLE, AnyNumber, NumberType
from polhode.scenes.scene import Scene
from polhode.taylor import defaults

METHODS = ("auto", "taylor", "refined")


class Options(NamedTuple):
    """How a scene is run in a number type; :func:`checked_options` checks what a user gives.

    ``tolerance``: of a step, the type's eps where it is None.  ``inputs``: the narrower type that
    start and coefficients are rounded to first.  ``digits``: those wanted, where the method can
    see to it by itself.  ``other``: for a run that another one is compared with: what a method
    chooses by itself, it chooses otherwise.
    """

    method: str = "auto"
    max_steps: int | None = None
    project: bool | int | None = None
    tolerance: Fraction | None = None
    inputs: NumberType | None = None
    digits: int | None = None
    other: bool = False

    def hindrance(self, scene: Scene, number: NumberType) -> str | None:
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
        if self.tolerance is not None or self.inputs is not None or self.project:
            return "no tolerance, rounded inputs or projection of its own"
        if scene.log10_angle > _MOST_LOG10_ANGLE:
            return f"a motion of at most 10**{_MOST_LOG10_ANGLE} radians"
        if readout.at_rest(scene).state:
            return "a motion that does not stand still"
        return None


USUAL = Options()


def checked_options(
    scene: Scene, number: NumberType, options: Options, tol: AnyNumber | None
) -> Options:
    """Options as a user gives them, and the tolerance, checked; raises BadInput."""
    if options.method != "auto":
        check_method(scene, options.method)
    most, project, tolerance = options.max_steps, options.project, options.tolerance
    if most is not None:
        most = steps(scene.name, most)
    if project is not None and not isinstance(project, bool):
        project = whole(scene.name, "project", project, 1)
    if tol is not None:
        tolerance = rounded_tolerance(scene, number, tol)
    return options._replace(max_steps=most, project=project, tolerance=tolerance)


def check_method(scene: Scene, method: str) -> None:
    """Raise BadInput for a method that is none."""
    if method not in METHODS:
        of_kind(scene.name, "method", method, str, ", ".join(METHODS))
        raise BadInput(scene.name, "method", method, nearest(method, list(METHODS)))


def choose_number(
    scene: Scene, number: str | NumberType | None, digits: int | None, lost: float = 0.0
) -> NumberType:
    """The number type that was named, or the cheapest one that holds the digits wanted.

    ``lost``: the digits that the motion is expected to lose, where that was measured.
    """
    name = number.name if isinstance(number, NumberType) else number
    if name is not None:
        listed = ", ".join(number_types.NAMES)
        of_kind(scene.name, "number", name, str, f"{listed}, or a NumberType")
    if name is not None and name not in number_types.NAMES:
        raise BadInput(scene.name, "number", name, nearest(name, list(number_types.NAMES)))
    if name == "extended" and not number_types.extended_here():
        raise BadInput(scene.name, "number", name, "quad: long double has no 64 bits here")
    if digits is not None:
        digits = whole(scene.name, "digits", digits, 1, number_types.MAX_DIGITS)
    if isinstance(number, NumberType):
        whole(scene.name, "bits", number.bits, 2)
        if not number_types.is_possible(number):
            own = f"{number_types.named(number.name).bits} bits, or a NumberType of mp"
            raise BadInput(scene.name, "number", f"{number.name} of {number.bits} bits", own)
        return number
    if digits is None:
        return DOUBLE if number is None else number_types.named(number)
    chosen = number_types.for_digits(digits, scene.log10_angle, lost)
    if number is None or number == chosen.name:
        return chosen
    if number == "mp":
        return number_types.mp_for(digits, scene.log10_angle, lost)
    if number_types.named(number).bits < chosen.bits:
        raise BadInput(scene.name, "digits", digits, f"fewer in {number}; {chosen.name} holds them")
    return number_types.named(number)


def rounded_tolerance(scene: Scene, number: NumberType, tol: AnyNumber) -> Fraction:
    """The tolerance of a step, checked."""
    try:
        exact = exact_number(tol)
    except (TypeError, ValueError):
        raise BadInput(scene.name, "tol", plain(tol), "a number") from None
    if not isinstance(exact, Fraction) or not number.eps <= exact <= 0.1:  # the double, too
        lowest = f"2**-{number.bits - 1}"
        raise BadInput(scene.name, "tol", plain(tol), f"between eps = {lowest} and 0.1")
    return exact


def cadence(scene: Scene, number: NumberType, options: Options) -> int | None:
    """Steps between two projections of the run onto its first integrals, None for none."""
    choices, project = defaults.of(number), options.project
    if project is None:
        loose = options.tolerance is not None and options.tolerance > number.eps
        project = choices.projected and not loose
    if scene.form != "principal" or options.inputs is not None or project is False:
        return None
    return choices.project_every if project is True else project


# --- refinement -----------------------------------------------------------------------------------
#
# When a run is refined: double corrected by exact arithmetic, where that serves and is faster.


#: Forms whose variables are linear functions of the principal one's.  Gauss collocation gives the
#: same states in each of them, so it is done in principal axes.
LINEAR = ("principal", "general", "inertia-axes", "momentum", "gyration-axes")

_MOST_LOG10_ANGLE = 12  # beyond it no run ends
#: Radians turned from which on refinement is the faster way: from 10 on once what is compiled is
#: loaded, from 80 on in a process that has to load it.
_LEAST_ANGLE = 20.0
_LEAST_ANGLE_MP = 120.0  # for more limbs than quad's, whose field takes seconds to compile once


def refinement_pays(scene: Scene, number: NumberType) -> bool:
    """Whether a run is long enough for refinement to be the faster way."""
    least = _LEAST_ANGLE if int(number.most_digits) <= 34 else _LEAST_ANGLE_MP
    return bool(scene.log10_angle >= math.log10(least))
