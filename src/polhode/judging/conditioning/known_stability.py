"""Whether nearby motions leave a known motion exponentially, decided without a long run.

What stands still, a state or the angular velocity of a free body: by the eigenvalues of the linear
equations, exactly.  They are those of a Hamiltonian system with two Casimirs, 0, 0, ±mu1, ±mu2,
so that with s = tr J^2/2, t = tr J^4/2 the squares of mu are the roots of

    x^2 - s x + (s^2 - t)/2,    real and not above 0 if and only if no mu has a real part.

A periodic closed form: by its residue (6 - tr M)/4, M the change of the state over a period, whose
multipliers are 1, 1, 1, 1, mu, 1/mu: hyperbolic outside 0 to 1.  An integrable top on one of its
tori, which a closed form tells by frequencies: nearby motions are on nearby tori.  Any other closed
form tends to a motion that it never is (a separatrix), or is not known well enough.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from polhode.equations.equilibrium import at_rest
from polhode.equations.forms import principal
from polhode.judging.conditioning.motion_kinds import is_integrable
from polhode.judging.references.reference import Reference, reference
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import EXACT, FLOATS
from polhode.scenes.scene import Scene
from polhode.taylor.system import System
from polhode.taylor.variations import Variations

_TORI = {"polhode", "nutation", "s1"}  # rates that an integrable top has on its tori alone
_ANY_TORI = {"u", "turning"}  # rates of tori of other tops
_PARABOLIC = 1e-5  # of |M|: residues so near to 0 or 1 are not told from them


class Known(NamedTuple):
    """What is known of a motion's neighbours.

    ``rate``: of their exponential growth per unit of the run's time, 0 where there is none, None
    where it is not known.  ``words``: by what.  ``tends``: to another motion.
    """

    rate: float | None
    words: str
    tends: bool = False


def known_stability(scene: Scene, plain: System, most: int) -> Known:
    """What is known of the neighbours of a scene's motion, in at most so many steps of a period.

    ``plain``: the system in principal axes.
    """
    rest = at_rest(scene)
    if rest.state or (rest.omega and scene.body.torque_free):
        count = len(plain.start) if rest.state else 3
        return Known(_growth_at_rest(plain, count), "its eigenvalues")
    motion = reference(scene)
    if not isinstance(motion, Reference):
        return Known(None, "")
    rates = motion.frequencies.keys()
    if (is_integrable(scene.body) and rates & _TORI) or "u" in rates:
        return Known(0.0, "the torus that it lies on")
    if motion.period is not None:
        rate = _growth_of_period(plain, float(motion.period) / float(Frame.of(scene).unit), most)
        return Known(rate, "the residue of its period")
    return Known(None, "", not rates & _ANY_TORI and "quasi-periodic" not in motion.regime)


def growth_about(plain: System, state: Doubles) -> float:
    """The largest growth rate of the linear equations at a state of principal axes, in double."""
    numbers = {name: to_double(x) for name, x in plain.coefficients.items()}
    count = len(plain.start)
    matrix = np.empty((count, count))
    for k, unit in enumerate(np.eye(count)):
        ahead, behind = (principal.field([*(state + x)], numbers, FLOATS) for x in (unit, -unit))
        matrix[:, k] = (np.array(ahead) - behind) / 2  # exact but for rounding: rates are quadratic
    return float(np.linalg.eigvals(matrix).real.max())


def _growth_at_rest(plain: System, count: int) -> float:
    """The largest real part of an eigenvalue at the start, of the first ``count`` variables."""
    k, start = plain.coefficients, [*plain.start[:count]]
    columns = []
    for place in range(count):
        ahead, behind = ([*start], [*start])
        ahead[place], behind[place] = start[place] + 1, start[place] - 1
        pair = (principal.field(x, k, EXACT) for x in (ahead, behind))
        columns.append([(one - other) / 2 for one, other in zip(*pair, strict=True)])
    square = [[_sum(columns, i, row) for i in range(count)] for row in range(count)]
    s = _total(square[i][i] for i in range(count)) / 2
    t = _total(square[i][j] * square[j][i] for i in range(count) for j in range(count)) / 2
    product, gap = (s * s - t) / 2, 2 * t - s * s
    if sign(s) <= 0 <= min(sign(product), sign(gap)):
        return 0.0
    root = cmath.sqrt(to_double(gap))
    squares = [(to_double(s) + way * root) / 2 for way in (1, -1)]
    return max(abs(cmath.sqrt(x).real) for x in squares) or math.ulp(0.0)


def _sum(columns: Sequence[Sequence[Exact]], column: int, row: int) -> Exact:
    return _total(columns[k][row] * columns[column][k] for k in range(len(columns)))


def _total(terms: Iterable[Exact]) -> Exact:
    return sum(terms, ZERO)


def _growth_of_period(plain: System, period: float, most: int) -> float | None:
    flow = Variations(plain.coefficients, np.array([*map(to_double, plain.start)]), np.eye(6))
    reached = flow.to(period, most)
    change = flow.tangents * 2.0**flow.exponent
    flow.release()
    residue = (6 - float(np.trace(change))) / 4
    away = max(-residue, residue - 1)
    sure = _PARABOLIC * float(np.linalg.norm(change))
    if not reached or abs(away) <= sure or min(abs(residue), abs(1 - residue)) <= sure:
        return None
    half = abs(1 - 2 * residue)
    return math.acosh(half) / abs(period) if away > 0 else 0.0
