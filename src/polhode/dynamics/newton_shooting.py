"""Newton's method for an orbit that closes, in double: a bordered system of ten equations.

The end of a motion keeps h, f and n = |gamma|^2, so of the six equations x(T) = x only three
are independent: at a closed orbit the gradients of the integrals are left null vectors of [M -
1, x'], M the monodromy matrix. With one multiplier for each of them,

    x(T) - x + a1 grad h + a2 grad f + a3 grad n = 0,   and four conditions on x and T,

is square in (x, T, a); at its solutions a = 0. Held at a level the conditions are h, f, n and
(x - x0)·x' = 0: the matrix is then regular unless M has a further multiplier 1. Along a family
(:mod:`polhode.dynamics.newton_shooting`) one of h and f gives way to a length of
arc, and it stays regular through folds. (Borders as in W. Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria, SIAM 2000, chapter 3.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.common.values import ByValue, cached_property
from polhode.equations.forms import principal
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, FLOATS, Doubles, GivenRow, Scalar, double_array
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene
from polhode.taylor.heyoka import OutOfRange
from polhode.taylor.variations import Flow, NotFollowed

# --- level set ------------------------------------------------------------------------------------
#
# The surface of one level on which orbits close: h, f and |gamma|^2, their gradients, the rates.
#
# In principal axes and the run's unit of time, moments and Mg r0 divided by the largest moment, so
# that everything is of order one:
#
#     h = ½ w·I w + Mg r0·gamma,  f = I w·gamma,  n = |gamma|²
#     grad h = (I w, Mg r0),  grad f = (I gamma, I w),  grad n = (0, 2 gamma)


@dataclass(frozen=True, eq=False)
class Surface(ByValue):
    """The level (h, f) of a scene's body; ``h`` and ``f`` exact, in the scene's units."""

    scene: Scene
    h: Exact
    f: Exact

    @cached_property
    def inside(self) -> Scene:
        """The scene inside its frame."""
        return Frame.of(self.scene).inside(self.scene)

    @cached_property
    def unit(self) -> Fraction:
        """The run's unit of time in the scene's."""
        return Frame.of(self.scene).unit

    @cached_property
    def exact_moments(self) -> tuple[Exact, ...]:
        """A, B, C over the largest."""
        largest = max(self.scene.body.moments)
        return tuple(a / largest for a in self.scene.body.moments)

    @cached_property
    def exact_torque(self) -> tuple[Exact, ...]:
        """Mg r0 over the largest moment."""
        body = self.inside.body
        return tuple(x / max(body.moments) for x in body.torque)

    @cached_property
    def exact_level(self) -> tuple[Exact, Exact]:
        """h and f."""
        largest = max(self.scene.body.moments)
        return self.h * self.unit * self.unit / largest, self.f * self.unit / largest

    @cached_property
    def exact_start(self) -> tuple[Exact, ...]:
        """The scene's own start."""
        return self.inside.start

    @cached_property
    def coefficients(self) -> dict[str, Exact]:
        """Of the equations."""
        return principal.coefficients(self.inside.body)

    @cached_property
    def moments(self) -> Doubles:
        """A, B, C over the largest."""
        return np.array([to_double(a) for a in self.exact_moments])

    @cached_property
    def torque(self) -> Doubles:
        """Mg r0 over the largest moment."""
        return np.array([to_double(x) for x in self.exact_torque])

    @cached_property
    def level(self) -> Doubles:
        """h, f and 1."""
        return np.array([*(to_double(x) for x in self.exact_level), 1.0])

    @cached_property
    def shortest(self) -> float:
        """No orbit on the level closes in less, by 2 pi over a Lipschitz constant of the rates.

        (J. A. Yorke, Proc. Amer. Math. Soc. 22 (1969) 509.)  With W above every |w| and
        W^2 >= 2|T|/C, T = Mg r0 and C the least moment, the Jacobian of the rates of (w/W, gamma)
        has four blocks no larger than sqrt(2) W, W/2, W and W: L < 2.07 W.
        """
        least, torque = float(self.moments.min()), float(np.linalg.norm(self.torque))
        fastest = (2 * (max(0.0, float(self.level[0])) + torque) / least) ** 0.5
        return 2 * np.pi / (2.07 * fastest) if fastest else np.inf

    @cached_property
    def flow(self) -> Flow:
        """The flow with its derivative, in double."""
        return self._flow(derivative=True)

    @cached_property
    def plain_flow(self) -> Flow:
        """The flow alone, in double."""
        return self._flow(derivative=False)

    def _flow(self, derivative: bool) -> Flow:
        """The flow in double; raises BadInput for a body whose numbers doubles do not hold."""
        try:
            return Flow(self.coefficients, DOUBLE, derivative)
        except OutOfRange as fault:
            raise fault.refusal(self.scene.name, DOUBLE) from None

    def rates(self, state: Doubles) -> Doubles:
        """The time derivative of a state."""
        return np.array(principal.field([*state], self._numbers, FLOATS))

    @cached_property
    def _numbers(self) -> dict[str, float]:
        return {name: to_double(x) for name, x in self.coefficients.items()}

    def integrals(self, state: Doubles) -> Doubles:
        """h, f and |gamma|^2 of a state."""
        return np.array(integrals(self.moments, self.torque, state))

    def gradients(self, state: Doubles) -> Doubles:
        """Their gradients, three rows of six."""
        return np.array(gradients(self.moments, self.torque, state))

    def scale(self, state: Doubles) -> Doubles:
        """What an error of each component is measured by: the rates' scale, and 1."""
        fastest = max(float(np.linalg.norm(state[:3])), float(np.linalg.norm(self.torque)) ** 0.5)
        return np.array([fastest] * 3 + [1.0] * 3)


def integrals(moments: GivenRow, torque: GivenRow, state: GivenRow) -> list[Scalar]:
    """h, f and |gamma|^2 of one state, for any scalars."""
    w, g = state[:3], state[3:]
    momentum = [a * x for a, x in zip(moments, w, strict=True)]
    return [dot(momentum, w) / 2 + dot(torque, g), dot(momentum, g), dot(g, g)]


def gradients(moments: GivenRow, torque: GivenRow, state: GivenRow) -> list[list[Scalar]]:
    """Their gradients, for any scalars."""
    w, g = state[:3], state[3:]
    momentum, inertial = ([a * x for a, x in zip(moments, v, strict=True)] for v in (w, g))
    return [
        [*momentum, *torque],
        [*inertial, *momentum],
        [*(0 * x for x in g), *(2 * x for x in g)],
    ]


# --- newton shooting ------------------------------------------------------------------------------


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
    fixed: list[int], on: Surface, level: Doubles, ways: Doubles, reference: Doubles
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
    inverse: Doubles = (right.T / parts) @ left.T
    return inverse


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
        residual = np.concatenate([end - state, values])
        miss = float(np.linalg.norm(residual))
        inverse = inverse_of(bordered(on, state, end, monodromy, rows))
        step = -(inverse @ residual)[:7]
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


# --- continuation ---------------------------------------------------------------------------------
#
# Families of periodic orbits: one of h and f changes, the other is held, folds are passed.
#
# Steps of pseudo-arclength: from a closed orbit a step along the family's tangent, then Newton's
# method at right angles to it (H. B. Keller 1977), in the bordered system of
# :mod:`polhode.dynamics.newton_shooting`, which needs no parameter: h and f are
# functions of the state. Where Greene's residue R passes 0 or 1 a further multiplier is 1 or -1:
# a fold where the parameter turns there, else a branch point; a period doubling at 1. Between two
# points they are found by regula falsi along the arc. A residue that touches 0 or 1 without
# passing is not seen.


FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.02, 0.1, 1e-6
EASY, HARD = 3, 6  # corrections at which a step is lengthened, shortened
STRAIGHT = 0.95  # cosine of the angle between two tangents
UNIQUE = 1e-9  # of the largest singular value: below it two families pass
BY = ("h", "f")
FOLD, BRANCH, DOUBLING, TARGET = "fold", "branch point", "period doubling", "target"


class Member(NamedTuple):
    """An orbit of a family: tangent to it (unit, scaled), the parameter and its slope along it."""

    found: Closed
    tangent: Doubles
    value: float
    slope: float

    @property
    def residue(self) -> float:
        """Greene's residue."""
        return self.found.residue


class Passed(NamedTuple):
    """A member of its own between two steps: a bifurcation, or where the parameter has a value."""

    what: str
    member: Member


class Arc:
    """The family through one orbit.  ``by``: h or f, what changes; the other one is held."""

    def __init__(self, on: Surface, first: Closed, by: str) -> None:
        self.on, self.index = on, BY.index(by)
        self.held = [1 - self.index, 2]
        self.level = np.append(on.integrals(first.state)[:2], 1.0)
        self.metric = np.append(on.scale(first.state), first.period)
        self.first = self.member(first, None)

    def next(self, member: Member, length: float) -> Member:
        """The member so far along the tangent; raises NotClosed."""
        ahead = np.append(member.found.state, member.found.period)
        ahead = ahead + length * self.metric * member.tangent
        ways = np.array([np.append(self.on.rates(member.found.state), 0.0), member.tangent])
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
            length = self.way(near, far)
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

    def way(self, base: Member, member: Member) -> float:
        """How far another member lies along a member's tangent."""
        ahead = np.append(
            member.found.state - base.found.state, member.found.period - base.found.period
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
        corrections = after.found.corrections
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
        ("", lambda member: member.residue),
        (DOUBLING, lambda member: member.residue - 1),
        *((TARGET, lambda member, end=end: member.value - end) for end in ends),
    ]
    for kind, off in marks:
        if off(member) * off(after) >= 0:
            continue
        at = arc.between(member, after, off)
        folds = member.slope * after.slope < 0
        special.append((arc.way(member, at), Passed(kind or (FOLD if folds else BRANCH), at)))
    return special
