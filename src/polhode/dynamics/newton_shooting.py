"""Newton's method for an orbit that closes, in double: a bordered system of ten equations.

The end of a motion keeps h, f and n = |gamma|^2, so of the six equations x(T) = x only three
are independent: at a closed orbit the gradients of the integrals are left null vectors of [M -
1, x'], M the monodromy matrix. With one multiplier for each of them,

    x(T) - x + a1 grad h + a2 grad f + a3 grad n = 0,   and four conditions on x and T,

is square in (x, T, a); at its solutions a = 0. Held at a level the conditions are h, f, n and
(x - x0)·x' = 0: the matrix is then regular unless M has a further multiplier 1. Along a family
one of h and f gives way to a length of
arc, and it stays regular through folds. (Borders as in W. Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria, SIAM 2000, chapter 3.)
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import fmpq_mat

from polhode.dynamics.level_body import LevelBody, gradients, integrals
from polhode.equations.forms import principal
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, Doubles, NumberType, double_array
from polhode.numbers.polynomials import rational
from polhode.numbers.vectors import dot
from polhode.taylor.variations import Flow, NotFollowed

# --- newton shooting ------------------------------------------------------------------------------


MOST_CORRECTIONS = 25
CLOSED = 1e-9  # a correction of this size that no longer falls is rounding
ROUNDING = 1e-14
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


def at_level(on: LevelBody, reference: Doubles) -> Conditions:
    """h, f and |gamma|^2 of the level; no way along the motion at a reference."""
    along = np.append(on.rates(reference), 0.0)
    return conditions([0, 1, 2], on, on.relative[2], along[None], np.append(reference, 0.0))


def conditions(
    fixed: list[int], on: LevelBody, level: Doubles, ways: Doubles, reference: Doubles
) -> Conditions:
    """Some of h, f and |gamma|^2 held at their values, no way from a reference along others.

    ``ways`` (n, 7), ``reference`` (7,): in state and period.
    """
    units = ways / np.linalg.norm(ways, axis=1)[:, None]

    def conditions(state: Doubles, period: float) -> tuple[Doubles, Doubles]:
        off = on.integrals(state)[fixed] - level[fixed]
        rows = np.zeros((4, 7))
        rows[: len(fixed), :6], rows[len(fixed) :] = on.gradients(state)[fixed], units
        return np.append(off, units @ (np.append(state, period) - reference)), rows

    return conditions


def bordered(
    on: LevelBody, state: Doubles, end: Doubles, monodromy: Doubles, rows: Doubles
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
    inverse: Doubles = (right.T / parts) @ left.T
    return inverse


def matrix_of(on: LevelBody, orbit: Closed, reference: Doubles) -> Doubles:
    """That matrix at a closed orbit of a level, held across the motion at a reference."""
    rows = at_level(on, reference)(orbit.state, orbit.period)[1]
    return bordered(on, orbit.state, orbit.state, orbit.monodromy, rows)


def closed(
    on: LevelBody, state: Doubles, period: float, conditions: Conditions | None = None
) -> Closed:
    """The closed orbit to which Newton's method leads from a guess; raises NotClosed.

    ``conditions``: those of the level, across the motion at the guess, unless given.
    """
    conditions = at_level(on, state) if conditions is None else conditions
    last, guess, miss = np.inf, period, np.inf
    for count in range(MOST_CORRECTIONS):
        if on.is_still(state, STILL):
            raise NotClosed("it led to a permanent rotation")
        try:
            reached = on.flow.after(state, period)
        except NotFollowed as fault:
            raise NotClosed(f"its motion could not be followed: {fault}") from None
        assert reached.derivative is not None
        end, monodromy = double_array(reached.state), double_array(reached.derivative)
        if not np.max(np.abs(monodromy)) < WILDEST:
            raise NotClosed(f"a period multiplies errors by {np.max(np.abs(monodromy)):.0e}")
        values, rows = conditions(state, period)
        residual = np.concatenate([end - state, values])
        miss = float(np.linalg.norm(residual))
        inverse = inverse_of(bordered(on, state, end, monodromy, rows))
        step = -(inverse @ residual)[:7]
        size = float(np.linalg.norm(step / _measure(on, state, period)))
        if size < ROUNDING or (size < CLOSED and size > last / 4):
            return Closed(state + step[:6], period + step[6], monodromy, inverse, count)
        last = size
        state, period = _damped(on, state, period, step, miss, conditions)
        if not guess / 3 < period < 3 * guess:
            raise NotClosed("the period left the neighbourhood of the guess")
    raise NotClosed(f"after {MOST_CORRECTIONS} corrections the motion still misses by {miss:.1e}")


def _measure(on: LevelBody, state: Doubles, period: float) -> Doubles:
    return np.append(on.scale(state), period)


def _damped(
    on: LevelBody, state: Doubles, period: float, step: Doubles, miss: float, conditions: Conditions
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


# --- more digits ----------------------------------------------------------------------------------
#
# A closed orbit in double carried on to many digits.
#
# The chord method: the ten residuals in a type wide enough, by the six equations alone, and
# corrections by the inverse that is known in double. A correction gains about ten digits. How far
# off the numbers are that are written down is then told by one more correction, computed from just
# these decimals in a wider type. The monodromy matrix is integrated once at the end; what its exact
# properties miss tells its digits.


SPARE_DIGITS = 2  # written beside those asked for
MOST_TYPES = 3  # tried until the digits are reached
DIGITS_OF_TURNS = 8  # at least: by chance one advance in 3000 is a fraction of a turn to so many
HELD = 15  # digits up to which a monodromy matrix in double is enough

Fractions = Sequence[Fraction]


class Refined(NamedTuple):
    """A start and a period as decimals, in the scene's axes and units, and how good they are.

    ``omega``, ``gamma``, ``period``: decimals of the digits asked for and two more; of a component
    that is smaller than its scale as many as make its place the same.  ``error``: the
    largest of their errors, w relative to its scale, gamma as it is, the period relative to itself.
    ``state``, ``time``: the numbers of ``number`` before they were rounded.
    """

    omega: tuple[str, ...]
    gamma: tuple[str, ...]
    period: str
    error: float
    state: tuple[Fraction, ...]
    time: Fraction
    number: NumberType
    corrections: int


class Monodromy(NamedTuple):
    """The monodromy matrix of a closed orbit: its trace and what its exact properties miss.

    ``determinant``: |det M - 1|.  ``missed``: the largest of |grad F M - grad F| over the three
    integrals F and |M x' - x'|, relative to the gradients and x'.
    """

    trace: Fraction
    determinant: float
    missed: float
    number: NumberType

    @property
    def residue(self) -> Fraction:
        """Greene's residue (6 - tr M)/4."""
        return (6 - self.trace) / 4


def refined(
    on: LevelBody,
    closed: Closed,
    digits: int,
    anchor: Sequence[Exact] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Refined:
    """So many digits of a closed orbit; raises NotClosed.

    ``anchor``: a state near the orbit, exact, its own in double unless given; the orbit's start x
    is where (x - anchor)·x' = 0 with x' the rates at the anchor, so that it is the same to all
    digits whatever double makes of it.
    """
    anchor = [Fraction(x) for x in closed.state.tolist()] if anchor is None else anchor
    near = np.array([to_double(x) for x in anchor])
    chord = Chord(on, closed.state, tuple(anchor), inverse_of(matrix_of(on, closed, near)))
    norms = (float(np.linalg.norm(x, 2)) for x in (chord.inverse, closed.monodromy))
    lost = sum(math.log10(max(1.0, norm)) for norm in norms)
    kind = type_for(math.ceil(digits + lost + 0.5))
    for _ in range(MOST_TYPES):
        state, time, count = _solved(chord, kind, closed.period, digits, tell)
        solution = _written(chord, state, time, kind, digits, count)
        if solution.error <= 10.0**-digits:
            return solution
        kind = number_types.wider(kind)
    raise NotClosed(f"in {kind.name} the error is {solution.error:.1e}, not below 1e-{digits}")


class Chord(NamedTuple):
    """What corrections are made of: a state near the orbit, the inverse of the system there.

    ``anchor``: see :func:`refined`.
    """

    on: LevelBody
    reference: Doubles
    anchor: tuple[Exact, ...]
    inverse: Doubles

    def correction(self, flow: Flow, state: Fractions, time: Fraction) -> list[Fraction]:
        """The step in x and T, its residual computed from numbers of the flow's type."""
        on, bits = self.on, flow.number.bits + 64
        try:
            end = flow.after(state, time).state
        except NotFollowed as fault:
            raise NotClosed(f"its motion could not be followed: {fault}") from None
        moments, torque, level = (
            [exact.nearest(x, bits) for x in v]
            for v in (on.exact_moments, on.exact_torque, (*on.exact_level, Fraction(1)))
        )
        values = integrals(moments, torque, state)
        anchor = [exact.nearest(x, bits) for x in self.anchor]
        numbers = {name: exact.nearest(x, bits) for name, x in on.coefficients.items()}
        rates = principal.field(anchor, numbers, number_types.EXACT)
        length = Fraction(math.hypot(*map(float, rates)))
        displacements = zip(rates, state, anchor, strict=True)
        residual = [
            *(a - b for a, b in zip(end, state, strict=True)),
            *(a - b for a, b in zip(values, level, strict=True)),
            sum((a * (x - r) for a, x, r in displacements), Fraction(0)) / length,
        ]
        size = max(map(abs, residual))
        if not size:
            return [Fraction(0)] * 7
        step = -(self.inverse @ np.array([float(x / size) for x in residual]))[:7]
        return [Fraction(x) * size for x in step.tolist()]


def _solved(
    chord: Chord,
    kind: NumberType,
    period: float,
    digits: int,
    tell: Callable[[str], None] | None,
) -> tuple[list[Fraction], Fraction, int]:
    """State and period in one type, and the number of corrections: as many as bring something."""
    flow = Flow(chord.on.coefficients, kind)
    state = [kind.rounded(Fraction(x)) for x in chord.reference.tolist()]
    time, goal = kind.rounded(Fraction(period)), Fraction(1, 10 ** (digits + 1))
    last: Fraction | None = None
    for count in itertools.count(1):
        step = chord.correction(flow, state, time)
        size = max(map(abs, step))
        if last is not None and size > last / 2:  # rounding, or no way to an orbit
            return state, time, count
        state = [kind.rounded(x + d) for x, d in zip(state, step, strict=False)]
        time, last = kind.rounded(time + step[6]), size
        if tell is not None:
            tell(f"correction {count}, {-exact.log10(size) if size else digits:.0f} digits")
        if size < goal:
            break
    return state, time, count


def _written(
    chord: Chord,
    state: Fractions,
    time: Fraction,
    kind: NumberType,
    digits: int,
    count: int,
) -> Refined:
    """As decimals in the scene's axes and units; their error from a correction in a wider type."""
    on = chord.on
    wide = number_types.wider(kind)
    bits = wide.bits + 64
    rows = [[exact.nearest(x, bits) for x in row] for row in on.scene.body.axes.rows]
    columns = [*zip(*rows, strict=True)]
    unit, written = on.unit, digits + SPARE_DIGITS
    scale = Fraction(float(on.scale(chord.reference)[0])) / unit
    omega = [decimal(dot(column, state[:3]) / unit, scale, written) for column in columns]
    gamma = [decimal(dot(column, state[3:]), Fraction(1), written) for column in columns]
    period = decimal_string(time * unit, written)
    # the way back from the decimals; gamma of length one, as the scene file has it
    w = [unit * Fraction(x) for x in omega]
    g = [Fraction(x) for x in gamma]
    length = exact.nearest(exact.sqrt(dot(g, g)), bits)
    again = [wide.rounded(dot(row, w)) for row in rows]
    again += [wide.rounded(dot(row, g) / length) for row in rows]
    own = wide.rounded(Fraction(period) / unit)
    step = chord.correction(Flow(on.coefficients, wide), again, own)
    measures = [*on.scale(chord.reference).tolist(), float(own)]
    error = max(float(abs(d)) / m for d, m in zip(step, measures, strict=True))
    return Refined(tuple(omega), tuple(gamma), period, error, tuple(state), time, kind, count)


def monodromy(on: LevelBody, state: Fractions, time: Fraction, digits: int) -> Monodromy:
    """The monodromy matrix at a closed orbit's start, for about so many digits of its trace."""
    kind = DOUBLE if digits <= HELD else type_for(digits + SPARE_DIGITS, QUAD.bits)
    flow = Flow(on.coefficients, kind, derivative=True)
    start = [kind.rounded(x) for x in state]
    rounded = [float(x) for x in start] if kind == DOUBLE else start
    matrix = flow.after(rounded, kind.rounded(time)).derivative
    assert matrix is not None
    rows = [[Fraction(x) for x in row] for row in matrix]
    moments, torque = (
        [exact.nearest(x, kind.bits) for x in v] for v in (on.exact_moments, on.exact_torque)
    )
    missed = Fraction(0)
    for row in gradients(moments, torque, start):
        moved = [sum((row[i] * rows[i][j] for i in range(6)), Fraction(0)) for j in range(6)]
        off = max(abs(a - b) for a, b in zip(moved, row, strict=True))
        missed = max(missed, off / max(map(abs, row)))
    off = abs(fmpq_mat([[rational(x) for x in row] for row in rows]).det() - 1)
    determinant = float(Fraction(int(off.p), int(off.q)))
    trace = sum((rows[i][i] for i in range(6)), Fraction(0))
    return Monodromy(trace, determinant, float(missed), kind)


def type_for(digits: int, least_bits: int = 0) -> NumberType:
    """The cheapest type wider than double that holds so many digits."""
    for kind in (EXTENDED, QUAD):
        there = kind != EXTENDED or number_types.extended_here()
        if there and kind.bits >= least_bits and digits <= kind.most_digits - 0.5:
            return kind
    return number_types.mp(digits)


def decimal(x: Fraction, scale: Fraction, digits: int) -> str:
    """x with the decimals that so many digits of a number of size ``scale`` have."""
    if not x:
        return "0"
    fewer = math.floor(exact.log10(abs(x) / scale))
    return decimal_string(x, min(digits, digits + fewer)) if digits + fewer > 0 else "0"


# --- continuation ---------------------------------------------------------------------------------
#
# Families of periodic orbits: one of h and f changes, the other is held, folds are passed.
#
# Steps of pseudo-arclength: from a closed orbit a step along the family's tangent, then Newton's
# method at right angles to it (H. B. Keller 1977), in the bordered system, which needs no
# parameter: h and f are functions of the state. Where Greene's residue R passes 0 or 1 a further
# multiplier is 1 or -1: a fold where the parameter turns there, else a branch point; a period
# doubling at 1. Between two points they are found by regula falsi along the arc. A residue that
# touches 0 or 1 without passing is not seen.


FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.02, 0.1, 1e-6
EASY, HARD = 3, 6  # corrections at which a step is lengthened, shortened
STRAIGHT = 0.95  # cosine of the angle between two tangents
UNIQUE = 1e-9  # of the largest singular value: below it two families pass
BY = ("h", "f")
FOLD, BRANCH, DOUBLING, TARGET = "fold", "branch point", "period doubling", "target"


class Member(NamedTuple):
    """An orbit of a family: tangent to it (unit, scaled), the parameter and its slope along it."""

    orbit: Closed
    tangent: Doubles
    value: float
    slope: float


class Passed(NamedTuple):
    """A member of its own between two steps: a bifurcation, or where the parameter has a value."""

    what: str
    member: Member


class Arc:
    """The family through one orbit.  ``by``: h or f, what changes; the other one is held."""

    def __init__(self, on: LevelBody, first: Closed, by: str) -> None:
        self.on, self.index = on, BY.index(by)
        self.held = [1 - self.index, 2]
        self.level = np.append(on.integrals(first.state)[:2], 1.0)
        self.metric = np.append(on.scale(first.state), first.period)
        self.first = self.member(first, None)

    def next(self, member: Member, length: float) -> Member:
        """The member so far along the tangent; raises NotClosed."""
        ahead = np.append(member.orbit.state, member.orbit.period)
        ahead = ahead + length * self.metric * member.tangent
        ways = np.array([np.append(self.on.rates(member.orbit.state), 0.0), member.tangent])
        ways[1] /= self.metric
        along = conditions(self.held, self.on, self.level, ways, ahead)
        orbit = closed(self.on, ahead[:6], float(ahead[6]), along)
        return self.member(orbit, member.tangent)

    def between(self, first: Member, last: Member, off: Callable[[Member], float]) -> Member:
        """Where a function of members vanishes that has two signs at two of them.

        At a branch point, where the system is singular, the nearest member that was found.
        """
        (near, at_near), (far, at_far) = (first, off(first)), (last, off(last))
        best, least = (near, at_near) if abs(at_near) < abs(at_far) else (far, at_far)
        for _ in range(40):
            length = self.distance(near, far)
            if abs(length) < 1e-14:
                break
            try:
                member = self.next(near, length * at_near / (at_near - at_far))
            except NotClosed:
                break
            value = off(member)
            if abs(value) < abs(least):
                best, least = member, value
            if abs(value) < 1e-14:
                break
            # Illinois: the end that stays counts half, so that it does not stay for ever
            if value * at_near > 0:
                near, at_near, at_far = member, value, at_far / 2
            else:
                far, at_far, at_near = member, value, at_near / 2
        return best

    def distance(self, base: Member, member: Member) -> float:
        """How far another member lies along a member's tangent."""
        ahead = np.append(
            member.orbit.state - base.orbit.state, member.orbit.period - base.orbit.period
        )
        return float(base.tangent @ (ahead / self.metric))

    def member(self, orbit: Closed, before: Doubles | None) -> Member:
        """An orbit as a member; its tangent in the direction of one before it."""
        on, state = self.on, orbit.state
        gradients = on.gradients(state)
        rows = np.zeros((4, 7))
        rows[:2, :6], rows[2, :6] = gradients[self.held], on.rates(state)
        matrix = bordered(on, state, state, orbit.monodromy, rows)[:9]
        matrix[:, :7] *= self.metric
        _, sizes, right = np.linalg.svd(matrix)
        if before is None and sizes[-1] < UNIQUE * sizes[0]:
            raise NotClosed("more than one family passes through this orbit")
        tangent = right[-1, :7] / np.linalg.norm(right[-1, :7])
        if before is not None and tangent @ before < 0:
            tangent = -tangent
        value = float(on.integrals(state)[self.index])
        slope = float(gradients[self.index] @ (self.metric[:6] * tangent[:6]))
        return Member(orbit, tangent, value, slope)


class FamilyStep(NamedTuple):
    """What one step along a family found: special members in order, and the member at its end."""

    passed: tuple[Passed, ...]
    member: Member
    length: float


def stepped(arc: Arc, member: Member, length: float, ends: tuple[float, ...]) -> FamilyStep:
    """One step, as long as is fit; raises NotClosed where none is.

    ``ends``: of the range of the parameter; the step ends where it leaves it.
    """
    why = ""
    while length >= SHORTEST_STEP:
        try:
            after = arc.next(member, length)
        except NotClosed as fault:
            why, length = str(fault), length / 2
            continue
        if after.tangent @ member.tangent < STRAIGHT:
            why, length = "the family bends too sharply", length / 2
            continue
        passed = sorted(_passed(arc, member, after, ends), key=lambda pair: pair[0])
        special = tuple(passage for _, passage in passed)
        corrections = after.orbit.corrections
        if corrections <= EASY:
            length = min(LONGEST_STEP, 1.5 * length)
        elif corrections >= HARD:
            length /= 2
        return FamilyStep(special, after, length)
    raise NotClosed(why)


def _passed(
    arc: Arc, member: Member, after: Member, ends: tuple[float, ...]
) -> list[tuple[float, Passed]]:
    """The special members of a step, each with its place along the step."""
    special = []
    marks: list[tuple[str, Callable[[Member], float]]] = [
        ("", lambda member: member.orbit.residue),
        (DOUBLING, lambda member: member.orbit.residue - 1),
        *((TARGET, lambda member, end=end: member.value - end) for end in ends),
    ]
    for kind, off in marks:
        if off(member) * off(after) >= 0:
            continue
        at = arc.between(member, after, off)
        folds = member.slope * after.slope < 0
        special.append((arc.distance(member, at), Passed(kind or (FOLD if folds else BRANCH), at)))
    return special
