"""The motions of the contest: random bodies of six kinds, each from a random start."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from polhode.equations.forms import principal
from polhode.judging.adaptive_precision import integrate
from polhode.judging.correct_digits import digits_of, log10_rate
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, bits_for
from polhode.numbers.rows import Rows
from polhode.peers.field import TERMS
from polhode.peers.prepared import Top
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import CHAOTIC, STARTED, TOPS, random_scene

KINDS = tuple(STARTED)
DRAWS = 8  # of each kind: as many bodies, each with a start of its own
DIGITS = 24  # asked of the closed forms
JUDGED = 11  # even times at which a run is judged, the end alone where it has no more

ENDS = (1, 10, 100, 1000, 10_000)
OUTPUTS = (2, 101, 10_001)
#: The longest runs of kinds whose digits are gone, or whose turns are too many, later.
LAST = {"chaotic": 100, "fast": 1000}


class Cell(NamedTuple):
    """A kind of motion to an end with so many output times, both ends counted."""

    kind: str
    end: int
    outputs: int

    @property
    def label(self) -> str:
        """Its name, by which one cell alone can be made again."""
        return f"{self.kind} t={self.end} outputs={self.outputs}"


class Draw(NamedTuple):
    """One body and start of a kind, exact and rounded to doubles."""

    scene: Scene
    top: Top
    start: Any


class Truth(NamedTuple):
    """States at the judged times as sums of two doubles, and the scale of w."""

    high: Any
    low: Any
    scale: float


def cells(kind: str) -> list[Cell]:
    """Every length and number of outputs of a kind."""
    ends = [end for end in ENDS if end <= LAST.get(kind, ENDS[-1])]
    return [Cell(kind, end, outputs) for end in ends for outputs in OUTPUTS]


def scene_of(kind: str, index: int, end: int, outputs: int) -> Scene:
    """A draw's scene at its output times, which are doubles."""
    number = CHAOTIC[index] if kind == "chaotic" else index
    return random_scene(kind, number, times(end, outputs))


def draw(kind: str, index: int, end: int, outputs: int) -> Draw:
    """A body of the kind and its start."""
    import numpy as np

    scene = scene_of(kind, index, end, outputs)
    body = scene.body
    terms = principal.coefficients(body)
    coefficients = np.array([to_double(terms.get(term, 0)) for term in TERMS])
    moments, torque = (np.array([*map(to_double, x)]) for x in (body.moments, body.torque))
    start = np.array([*map(to_double, scene.start)])
    return Draw(scene, Top(coefficients, moments, torque), start)


def present(kind: str) -> tuple[bool, ...]:
    """Which coefficients of the equations do not vanish for bodies of a kind."""
    found = [draw(kind, k, 1, 2).top.coefficients != 0 for k in range(DRAWS)]
    return tuple(bool(x) for x in sum(found) > 0)


def truth(kind: str, index: int, end: int) -> Truth:
    """The motion at the judged times: by its closed form, else by a refined run in quad."""
    import numpy as np

    from polhode.numbers.mpmath_context import mpmath

    scene = scene_of(kind, index, end, JUDGED)
    states: Rows
    if kind in TOPS:
        states = reference_of(scene).at(scene.times, DIGITS)
    else:
        states = integrate(scene, "quad").states
    bits = bits_for(DIGITS) + 32
    with mpmath.workprec(bits):
        high = np.array([[float(x) for x in row] for row in states])
        low = np.array([[float(x - float(x)) for x in row] for row in states])
        return Truth(high, low, 10 ** log10_rate(states, scene))


def digits(states: Any, true: Truth) -> float:
    """Correct digits, the worst over the judged times: the end alone of a single state."""
    import numpy as np

    found = np.asarray(states, dtype=float)
    picked = slice(-1, None) if len(found) == 1 else slice(None)
    errors = np.abs((found - true.high[picked]) - true.low[picked])
    errors[:, :3] /= true.scale
    worst = float(errors.max())
    with np.errstate(divide="ignore"):
        return digits_of(float(np.log10(worst)), DOUBLE.most_digits) if np.isfinite(worst) else 0.0


def judged(states: Any, outputs: int) -> Any:
    """Those of the states of a run that are judged."""
    return states[-1:] if outputs == 2 else states[:: (outputs - 1) // (JUDGED - 1)]


@cache
def times(end: int, outputs: int) -> tuple[Exact, ...]:
    """Even output times from 0 on, as doubles."""
    return tuple(DOUBLE.rounded(t) for t in even_times(Fraction(end), outputs))
