"""Newton's method for an orbit that closes, in double: a bordered system of ten equations.

The end of a motion keeps h, f and n = |gamma|^2, so of the six equations x(T) = x only three are
independent: at a closed orbit the gradients of the integrals are left null vectors of
[M - 1, x'], M the monodromy matrix.  With one multiplier for each of them,

    x(T) - x + a1 grad h + a2 grad f + a3 grad n = 0,   and four conditions on x and T,

is square in (x, T, a); at its solutions a = 0.  Held at a level the conditions are h, f, n and
(x - x0)·x' = 0: the matrix is then regular unless M has a further multiplier 1.  Along a family
(:mod:`polhode.dynamics.periodic_orbits.continuation`) one of h and f gives way to a length of arc,
and it stays regular through folds.  (Borders as in W. Govaerts, Numerical Methods for Bifurcations
of Dynamical Equilibria, SIAM 2000, chapter 3.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.numbers.rows import Doubles, double_array
from polhode.taylor.variations import NotFollowed

MOST_CORRECTIONS = 25
CLOSED = 1e-9  # a correction of this size that no longer falls is rounding
EXACT = 1e-14
SINGULAR = 1e-11  # singular values below this part of the largest count as zero
WILDEST = 1e11  # entry of a monodromy matrix that double can do something with
STILL = 1e-6  # of a rate: below it a state is a permanent rotation

#: Four conditions at a state and a period: their values, and their derivatives, four rows of seven.
Conditions: TypeAlias = Callable[[Doubles, float], tuple[Doubles, Doubles]]


class NotClosed(ArithmeticError):
    """Newton's method did not end at a periodic orbit: why."""


class Closed(NamedTuple):
    """A closed orbit: a state, the period, the monodromy matrix, the inverse of the system.

    ``inverse`` (10, 10): of the matrix of :func:`bordered`, by singular values.  ``corrections``:
    how many there were.
    """

    state: Doubles
    period: float
    monodromy: Doubles
    inverse: Doubles
    corrections: int

    @property
    def residue(self) -> float:
        """Greene's residue (2 - mu - 1/mu)/4: of six multipliers four are 1."""
        return (6.0 - float(np.trace(self.monodromy))) / 4


def at_level(on: Surface, reference: Doubles) -> Conditions:
    """h, f and |gamma|^2 of the level; no way along the motion at a reference."""
    along = np.append(on.rates(reference), 0.0)
    return conditions([0, 1, 2], on, on.level, along[None], np.append(reference, 0.0))


def conditions(
    held: list[int], on: Surface, level: Doubles, ways: Doubles, reference: Doubles
) -> Conditions:
    """Some of h, f and |gamma|^2 held at their values, no way from a reference along others.

    ``ways`` (n, 7), ``reference`` (7,): in state and period.
    """
    units = ways / np.linalg.norm(ways, axis=1)[:, None]

    def conditions(state: Doubles, period: float) -> tuple[Doubles, Doubles]:
        off = on.integrals(state)[held] - level[held]
        rows = np.zeros((4, 7))
        rows[: len(held), :6], rows[len(held) :] = on.gradients(state)[held], units
        return np.append(off, units @ (np.append(state, period) - reference)), rows

    return conditions


def bordered(
    on: Surface, state: Doubles, end: Doubles, monodromy: Doubles, rows: Doubles
) -> Doubles:
    """The matrix of the ten equations in x, T and the three multipliers."""
    matrix = np.zeros((10, 10))
    matrix[:6, :6] = monodromy - np.eye(6)
    matrix[:6, 6] = on.rates(end)
    matrix[:6, 7:] = on.gradients(state).T
    matrix[6:, :7] = rows
    return matrix


def inverse_of(matrix: Doubles) -> Doubles:
    """The inverse; across directions in which nothing is determined, no step."""
    left, sizes, right = np.linalg.svd(matrix)
    parts = np.where(sizes > SINGULAR * sizes[0], sizes, np.inf)
    found: Doubles = (right.T / parts) @ left.T
    return found


def closed(on: Surface, state: Doubles, period: float, conditions: Conditions) -> Closed:
    """The closed orbit to which Newton's method leads from a guess; raises NotClosed."""
    last, guess, miss = np.inf, period, np.inf
    for count in range(MOST_CORRECTIONS):
        _refuse_still(on, state)
        try:
            reached = on.flow.after(state, period)
        except NotFollowed as fault:
            raise NotClosed(f"its motion could not be followed: {fault}") from None
        assert reached.derivative is not None
        end, monodromy = double_array(reached.state), double_array(reached.derivative)
        if not np.max(np.abs(monodromy)) < WILDEST:
            raise NotClosed(f"a period multiplies errors by {np.max(np.abs(monodromy)):.0e}")
        values, rows = conditions(state, period)
        wanted = np.concatenate([end - state, values])
        miss = float(np.linalg.norm(wanted))
        inverse = inverse_of(bordered(on, state, end, monodromy, rows))
        step = -(inverse @ wanted)[:7]
        size = float(np.linalg.norm(step / _measure(on, state, period)))
        if size < EXACT or (size < CLOSED and size > last / 4):
            return Closed(state + step[:6], period + step[6], monodromy, inverse, count)
        last = size
        state, period = _damped(on, state, period, step, miss, conditions)
        if not guess / 3 < period < 3 * guess:
            raise NotClosed("the period left the neighbourhood of the guess")
    raise NotClosed(f"after {MOST_CORRECTIONS} corrections the motion still misses by {miss:.1e}")


def _measure(on: Surface, state: Doubles, period: float) -> Doubles:
    return np.append(on.scale(state), period)


def _damped(
    on: Surface, state: Doubles, period: float, step: Doubles, miss: float, conditions: Conditions
) -> tuple[Doubles, float]:
    """A step that is not too long and does not lead farther away."""
    size = float(np.max(np.abs(step / _measure(on, state, period))))
    part = min(1.0, 0.25 / size)
    for _ in range(8):
        x, time = state + part * step[:6], period + part * step[6]
        if size < 1e-3:  # near enough: Newton's steps need no watching
            return x, time
        try:
            end = double_array(on.plain_flow.after(x, time).state)
            off = np.concatenate([end - x, conditions(x, time)[0]])
            if np.linalg.norm(off) < (1 - part / 4) * miss:
                return x, time
        except NotFollowed:
            pass
        part /= 2
    return state + part * step[:6], period + part * step[6]


def _refuse_still(on: Surface, state: Doubles) -> None:
    if is_still(on, state):
        raise NotClosed("it led to a permanent rotation")


def is_still(on: Surface, state: Doubles, within: float = STILL) -> bool:
    """Whether a state is a permanent rotation: no rate but zero."""
    scale = on.scale(state)
    with np.errstate(all="ignore"):  # a body at rest has no scale of omega: nan, and no rotation
        rate = np.max(np.abs(on.rates(state) / scale))
    return bool(rate < within * max(1e-300, float(scale[0])))
