"""The jobs of a section: orbits and the level they keep to, plain data to be sent anywhere."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.checkpoint import Arrays
from polhode.dynamics.sections.coordinates import Ground
from polhode.dynamics.sections.starts import Asked
from polhode.equations.forms import principal
from polhode.equations.integrals import first_integrals
from polhode.equations.section_functions import HEIGHT, MOMENTUM, SectionZero
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.exact import Exact
from polhode.numbers.expression import odd_part
from polhode.numbers.rows import Doubles, double_array
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE

if TYPE_CHECKING:
    from polhode.taylor.event_batches import Crossed, SearchJob
    from polhode.taylor.projection import Level

LANES = 64  # orbits of a job: where one is over the next takes its lane
CHUNK = 160.0  # radians of the fastest rate between two projections
WORTH_A_PROCESS = 200_000  # crossings, of two seconds
PATIENCE = 1000.0  # the level's units of time without a crossing until an orbit is given up


def jobs_of(
    asked: Asked, on: Ground, zero: SectionZero, direction: int, count: int, states: Doubles
) -> list[SearchJob]:
    """The jobs of orbits from ``states``, LANES of them each, in principal axes and inner units.

    They are in the level's own unit of time, 2**``on.slower`` inner ones: what is a step there, and
    what rounding adds up to in it, is measured by that.
    """
    from polhode.taylor.event_batches import SearchJob, Watched

    scene = asked.scene
    frame, slower = Frame.of(scene).slower(on.slower), 2.0**on.slower
    level = level_of(scene, asked.h, asked.f, frame)
    k = principal.coefficients(frame.inside(scene).body)
    constants = tuple(map(to_double, k.values()))
    own = np.tile(constants, (len(states), 1))
    x, y, z = zero.arm
    arm = (x / slower, y / slower, z / slower)
    own_zero = zero._replace(arm=arm, unit=float(frame.unit))
    watched = Watched((*k,), STATE, own_zero, constants=constants)
    states = states * np.repeat([slower, 1.0], 3)
    chunk = 2.0 ** round(np.log2(CHUNK / (on.fastest * slower or 1.0)))
    patience = int(-(-PATIENCE // chunk))
    return [
        SearchJob(
            *(watched, direction, count, np.inf, chunk, own[first : first + LANES]),
            states[first : first + LANES],
            patience=patience,
            level=level,
        )
        for first in range(0, len(states), LANES)
    ]


def level_of(scene: Scene, h: Exact, f: Exact, frame: Frame) -> Level:
    """The integrals of a level, as those of a scene on it, inside a frame."""
    from polhode.equations import integrals
    from polhode.taylor.projection import Level

    known = first_integrals(frame.inside(scene))
    if integrals.CHAPLYGIN in known.onto and f != 0:
        known = integrals.FirstIntegrals(known.onto[:-1], known.order, known.coefficients)
    unit, largest = frame.unit, max(scene.body.moments)
    targets = (2 * h * unit * unit / largest, f * unit / largest, Fraction(1))
    coefficients = {name: to_extended(x) for name, x in known.coefficients.items()}
    return Level(known, coefficients, tuple(to_extended(x) for x in targets))


def zero_of(scene: Scene, on: Ground, by: str) -> SectionZero:
    """A section's function, scaled to order one; of an expression the odd part."""
    from polhode.equations.section_functions import SectionZero

    moments = tuple(float(a) for a in on.moments)
    side = -1.0 if on.weight < 0 and by != HEIGHT else 1.0
    size = on.largest_momentum if by == MOMENTUM else on.fastest
    arm = tuple(float(side * x / (size or 1.0)) for x in on.frame[2])
    frame = Frame.of(scene)
    rows = tuple(tuple(to_double(x) for x in row) for row in frame.axes.rows)
    return SectionZero(odd_part(by), moments, arm, rows, float(frame.unit))  # type: ignore[arg-type]


def worker_count(jobs: int, crossings: int) -> int:
    """Processes: as many as pay, for each costs half a second to begin.

    Threads would not do: at every crossing they wait for each other.
    """
    from polhode.common.processes import cores

    return max(1, min(cores(), jobs, jobs * LANES * crossings // WORTH_A_PROCESS))


def packed(result: Crossed) -> Arrays:
    """What a job found as arrays by name, to be kept in a file."""
    return {name: np.asarray(value) for name, value in result._asdict().items()}


def unpacked(held: Arrays) -> Crossed:
    """What a job found, from those arrays."""
    from polhode.taylor.event_batches import Crossed

    states, times, rests = (double_array(held[name]) for name in ("states", "times", "rests"))
    found, steps = (np.asarray(held[name], dtype=np.int64) for name in ("found", "steps"))
    outcomes, drift = tuple(held["outcomes"].tolist()), float(held["drift"].item())
    return Crossed(states, times, rests, found, steps, outcomes, drift)
