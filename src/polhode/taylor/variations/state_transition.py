"""What happens to small changes along a motion, stretch by stretch.

From the end of one stretch to that of the next a change v of the state, and changes c of the
equations' coefficients k in units u of their own, go over into

    Phi v + U c,    Phi' = J(x) Phi,    U' = J(x) U + u df/dk,    Phi = 1 and U = 0 before,

all in principal axes and the scene's own unit of time.  Stretches are short enough that a double
holds each Phi; products of them are taken by :mod:`polhode.judging.conditioning.rounding_errors`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.cached_property import cached_property
from polhode.equations.equilibrium import at_rest
from polhode.equations.forms import principal
from polhode.equations.system import System, system
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.integrator.prepared_system import PreparedSystem
from polhode.taylor.integrator.stepping import Integrator
from polhode.taylor.variations.equations import Variations
from polhode.taylor.variations.reference_trajectory import Leader, pendulum, six

STRIDES = (1.0, 8.0)  # units of the scene's own time a stretch: at least, at most
MOST_STRETCHES = 4000  # of the shortest
_TRIED = 20_000  # steps after which it is seen that no output is within reach
_DOUBLES_TRUE = 8.0  # log10 of |Phi| up to which the motion in double is the scene's to 7 digits


class Stretch(NamedTuple):
    """A part of the motion, at its end.

    ``time``: own unit.  ``state``: six components, principal axes.  ``steps``: Taylor steps in
    double along it, about.  ``carried``: Phi, (6, 6).  ``driven``: U, a column for each coefficient
    of :data:`polhode.equations.forms.principal.NAMES`.
    """

    time: float
    state: Doubles
    steps: float
    carried: Doubles
    driven: Doubles


@dataclass(frozen=True)
class Passage:
    """The stretches of a scene's motion up to its outputs, |t| increasing.

    ``outputs``: the output times in the scene's own unit; each ends a stretch, as far as they were
    reached.  ``note``: why not further, else empty.
    """

    scene: Scene
    outputs: tuple[float, ...]
    stretches: tuple[Stretch, ...]
    note: str

    @cached_property
    def plain(self) -> System:
        """The equations in principal axes."""
        return system(replace(self.scene, form="principal"), ())

    @cached_property
    def units(self) -> tuple[float, ...]:
        """The units u of the coefficients, in the order of the columns of U."""
        return coefficient_units(self.scene)

    @cached_property
    def turn(self) -> Doubles:
        """From principal axes to the scene's, as a matrix."""
        return np.array([[to_double(x) for x in row] for row in self.scene.body.axes.rows]).T

    @cached_property
    def rate_scale(self) -> float:
        """What changes of w are relative to: the largest |w| at the outputs, as in the digits."""
        asked = set(self.outputs)
        speeds = (float(np.linalg.norm(s.state[:3])) for s in self.stretches if s.time in asked)
        return max(speeds, default=0.0) or pendulum(self.scene)


def passage(scene: Scene, max_steps: int = 400_000, until: float = math.inf) -> Passage:
    """The stretches of a scene's motion to its output times.

    Once the motion in double is no longer the scene's, it is led along one in a wider type.
    ``max_steps``: of about 35 µs; where not even the first output is within them, some are taken.
    ``until``: log10 of |Phi| of the whole way beyond which nothing is wanted; the passage ends
    there without a note.
    """
    unit = 2.0**scene.time_unit
    outputs = tuple(to_double(t / Fraction(2) ** scene.time_unit) for t in scene.times)
    plain = system(replace(scene, form="principal"), ())
    start = six(plain.start)
    w = float(np.linalg.norm(start[:3])) or pendulum(scene)
    sizes = np.array([w, w, w, 1.0, 1.0, 1.0])
    units = np.array(coefficient_units(scene))
    used = np.flatnonzero(units)  # of a free body three: the fewer tangents, the shorter it takes
    tangents = np.hstack([np.diag(sizes), np.zeros((6, len(used)))])
    drives = [{principal.NAMES[k]: exactly(units[k])} for k in used]
    flow = Variations(plain.coefficients, start, tangents, drives)
    leader: Leader | None = None
    still = at_rest(scene).state
    found: list[Stretch] = []
    whole, height, before, note = np.eye(6), 0.0, 0, ""
    nearest = min((abs(t) for t in outputs if t), default=0.0)
    for t in _moments(outputs):
        flow.restart(tangents)
        if flow.steps > _TRIED and 2 * abs(flow.time) * max_steps < nearest * flow.steps:
            note = f"not followed beyond t = {flow.time * unit:.3g}: more than {max_steps} steps"
            break
        if not (t == 0 or flow.to(t, max_steps - flow.steps)) or not flow.finite:
            more = flow.steps >= max_steps
            why = f"more than {max_steps} steps" if more else "not finite in double"
            note = f"not followed beyond t = {flow.time * unit:.3g}: {why}"
            break
        if still:
            flow.state = start
        elif leader is not None:
            flow.state = leader.at(t, height)
        carried = flow.tangents[:, :6] / sizes
        driven = np.zeros((6, len(units)))
        driven[:, used] = flow.tangents[:, 6:]
        found.append(Stretch(t, flow.state.copy(), flow.steps - before, carried, driven))
        before = flow.steps
        whole = carried @ whole
        largest = float(np.max(np.abs(whole / sizes[:, None] * sizes)))
        height += math.log10(largest)
        whole /= largest
        if height > until:
            break
        if leader is None and not still and height > _DOUBLES_TRUE:
            leader = Leader(plain)
            flow.state = leader.at(t, height)
    flow.release()
    return Passage(scene, outputs, tuple(_with_plain_steps(found, plain)), note)


def _with_plain_steps(found: list[Stretch], plain: System) -> list[Stretch]:
    """Stretches with their share of the steps that a run without tangents and outputs takes."""
    tangents_steps = sum(s.steps for s in found)
    if not tangents_steps:
        return found
    run, outcome = Integrator(PreparedSystem(plain, DOUBLE)), Outcome.STEP_LIMIT
    while outcome is Outcome.STEP_LIMIT:
        _, outcome = run.chunk([Fraction(found[-1].time)], defaults.of(DOUBLE).chunk)
    share = run.steps / tangents_steps
    run.release()
    return [s._replace(steps=s.steps * share) for s in found]


def coefficient_units(scene: Scene) -> tuple[float, ...]:
    """The unit of each coefficient: what it changes by where an input changes by itself."""
    found = dict.fromkeys(principal.NAMES, 0.0)
    for by in principal.sensitivities(scene.body, scene.time_unit):
        for name, x in by.items():
            found[name] = max(found[name], abs(to_double(x)))
    return tuple(found.values())


def _moments(outputs: Sequence[float]) -> Iterator[float]:
    """The output times and every multiple of the stride between them, away from 0."""
    least, most = STRIDES
    end = abs(outputs[-1]) if outputs else 0.0
    stride = min(most, max(least, end / MOST_STRETCHES))
    done = 0
    for t in outputs:
        while (done + 1) * stride < abs(t):
            done += 1
            yield math.copysign(done * stride, t)
        if abs(t) == (done + 1) * stride:
            done += 1
        yield t
