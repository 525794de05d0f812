"""heyoka's integrator with views of its memory: it stands wherever it is put, one user at a time.

Building one takes milliseconds even when its code is found on the disk, and so does freeing it:
as long as a short run itself. So whoever needs one takes one that is idle, and leaves it to the
next user. That may be of another body: whoever takes one tells it all coefficients, and the
state.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Any, Protocol, TypeAlias, cast

import numpy as np

from polhode.common.interrupts import Lock, LockPlace
from polhode.common.values import cached_property
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome
from polhode.numbers.double_double import two_sum
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE, Array, Functions, Numbers, NumberType, Scalar
from polhode.taylor import defaults
from polhode.taylor.heyoka import (
    EXPRESSIONS,
    CompiledFunction,
    Expression,
    HeyokaEvent,
    HeyokaIntegrator,
    HeyokaNumber,
    HeyokaOutput,
    array,
    as_fraction,
    compact_beyond,
    disk_cache,
    ending,
    hy,
    scalar,
    type_options,
)

# --- angle variables ------------------------------------------------------------------------------
#
# Variables that grow without bounds and on which no rate depends: angles.
#
# heyoka's steps are as accurate as its largest variable asks, and neglect the others.  So cyclic
# variables are kept as time is: an offset of more than twice the bits, plus heyoka's own part,
# which is divided by a power of two and set back to zero so often that it stays below about one.


class Cyclic:
    """The last variables of a system, from where they start; ``every``: steps to a set-back."""

    def __init__(self, start: Sequence[Number], number: NumberType) -> None:
        chosen = defaults.of(number)
        self.number, self.every = number, chosen.set_back
        self._divisor = chosen.divisor
        self._fine = 2 * number.bits + 64  # bits behind the point of the offsets, which are ints
        whole = [number.rounded(x) for x in start]
        self._grown = [(x.numerator << self._fine) // x.denominator for x in whole]
        self._parts = self._split() if number.flat else []

    def at_start(self) -> Cyclic:
        """One of a run's own, at the start where this one stands."""
        clone = object.__new__(Cyclic)
        clone.__dict__.update(self.__dict__)
        return clone

    def set_back(self, state: Array) -> None:
        """Move what the cyclic variables of a state have grown by to their offsets."""
        first = len(state) - len(self._grown)
        self.stand_at([self._whole(i, x) for i, x in enumerate(state[first:])])
        for i in range(first, len(state)):
            state[i] = scalar(0, self.number)

    @property
    def grown(self) -> tuple[int, ...]:
        """The offsets, for ``stand_at``."""
        return tuple(self._grown)

    def stand_at(self, grown: Sequence[int]) -> None:
        """Have these offsets."""
        self._grown, self._parts = [*grown], []

    def _split(self) -> list[tuple[HeyokaNumber, HeyokaNumber]]:
        """Each offset as two numbers of the type."""
        pairs = []
        for grown in self._grown:
            whole = Fraction(grown, 1 << self._fine)
            high = self.number.rounded(whole)
            low = self.number.rounded(whole - high)
            pairs.append((scalar(high, self.number), scalar(low, self.number)))
        return pairs

    def completed(self, rows: Array) -> Array:
        """Rows of heyoka's numbers, now with the whole of the cyclic variables."""
        if self.number.flat:
            self._parts = self._parts or self._split()
            for i, (high, low) in enumerate(self._parts, -len(self._parts)):
                near, rest = two_sum(high, rows[:, i] * self._divisor)
                rows[:, i] = near + (rest + low)
            return rows
        for row in rows:
            for i, x in enumerate(row[len(row) - len(self._grown) :], -len(self._grown)):
                row[i] = scalar(Fraction(self._whole(i, x), 1 << self._fine), self.number)
        return rows

    def _whole(self, i: int, part: HeyokaNumber) -> int:
        """A cyclic variable, of which heyoka has this part, as the offsets are kept."""
        x = part if self.number.flat else as_fraction(part, self.number)
        above, below = x.as_integer_ratio()
        return self._grown[i] + (above * self._divisor << self._fine) // below


# --- singularities --------------------------------------------------------------------------------
#
# Where a form of the equations is singular: a run ends near there.


def nearest(number: NumberType) -> Fraction:
    """The smallest distance to a form's singular set, about sqrt(eps): a run ends there.

    A distance is a square (sin² theta), so the set is met within about eps**(1/4).  A passage at
    d was measured to cost log10(1/d) digits: a run that goes on keeps three quarters of its own.
    """
    return Fraction(2) ** -((number.bits - 1) // 2)


def terminal_event(distance: Expression, number: NumberType) -> HeyokaEvent:
    """heyoka's event that ends the steps where the distance falls to :func:`nearest`.

    It is scaled down, so that it takes no part in choosing the steps.
    """
    damped = Fraction(2) ** -(number.bits // 2)
    near, damping = (scalar(x, number) for x in (nearest(number), damped))
    kind = {name: x for name, x in type_options(number).items() if name == "fp_type"}
    return hy.t_event(hy.expression(damping) * (distance - hy.expression(near)), **kind)


# --- specification --------------------------------------------------------------------------------
#
# The equations that compiled code is of, by value, and the one builder of heyoka's integrators.
#
# In the principal form the coefficients of the body are heyoka's parameters, so that one compiled
# integrator serves all bodies of a pattern: those of which the same coefficients are exactly
# zero. Compiling takes a quarter of a second, being found on the disk some milliseconds; a step
# takes as long as with constants. Coefficients that are equal, 1 or -1 make no pattern of their
# own.
#
# Variables that the equations keep, such as the spin of a symmetric body, stand in the rates as
# parameters, too: what they are multiplied by is then linear in the others, and heyoka need not
# multiply two power series. That takes a tenth off a step in double, a third in quad.


#: Rates of variables by the coefficients, for any scalar and for heyoka's expressions; and how near
#: a state is to the singular set, see :class:`polhode.equations.form.Form`.
Field: TypeAlias = Callable[[Sequence[Scalar], Mapping[str, Scalar], Functions], list[Scalar]]
Distance: TypeAlias = Callable[[Sequence[Scalar], Mapping[str, Scalar], Functions], Scalar]
Rates: TypeAlias = Callable[[Sequence[Expression], Mapping[str, Expression]], list[Expression]]

#: heyoka's parameters: so many for the time of events and their first step, one for each event,
#: then the coefficients of the pattern, then the variables that are kept.  Without events the
#: coefficients are the first.
CLOCK = 3
#: Added to all that heyoka watches, during the first step of a run.
TINY = 2
#: Before the coefficients among the parameters of a desk's functions: two parts of the time.
DESK = 2

LONG = 500  # operations of a run's events whose code is compiled as loops


@dataclass(frozen=True)
class Equations:
    """What tells compiled code from any other, without its events.

    ``columns``: the variables, of which the last ``cyclic`` ones are cyclic (:class:`Cyclic`).
    ``pattern``: the coefficients that are parameters.  ``constants``: those of a form whose
    coefficients are none.  ``still``: no rate but zero.  ``lanes``: of a batch, 0 for one motion.
    ``tangents``: so many columns u with u' = J(x) u follow the state; of the last ``driven`` of
    them the rate of the state by coefficients of their own is added, which stand behind the first
    ones.  ``order``: of a step, at least heyoka's own for the tolerance; 0: that one.
    """

    columns: tuple[str, ...]
    pattern: tuple[str, ...]
    number: NumberType = DOUBLE
    tolerance: Fraction | None = None
    form: str = "principal"
    constants: tuple[tuple[str, Fraction], ...] = ()
    still: bool = False
    cyclic: int = 0
    lanes: int = 0
    tangents: int = 0
    driven: int = 0
    order: int = 0

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(getattr(self, field.name) for field in fields(self)))

    def coefficients(self, first: int) -> dict[str, Expression]:
        """Parameters from a first one on, or constants."""
        named = {name: hy.par[i] for i, name in enumerate(self.pattern, first)}
        for name, x in self.constants:
            named[name] = hy.expression(scalar(x, self.number))
        return named


def built(
    equations: Equations,
    field: Field = principal.field,
    distance: Distance | None = None,
    watcher: EventWatcher | None = None,
) -> Engine:
    """An engine of equations by a form's field, that ends near the form's singular set."""
    number, options, desk = equations.number, dict[str, Any](), None
    x = hy.make_vars(*equations.columns)
    first = 0 if watcher is None else CLOCK + len(watcher.damping)
    pattern, k = equations.pattern, equations.coefficients(first)
    growing = len(x) - equations.cyclic

    def rates_at(
        state: Sequence[Expression], numbers: Mapping[str, Expression]
    ) -> list[Expression]:
        rates = field(state, numbers, EXPRESSIONS)
        if not equations.cyclic:
            return rates
        unit = hy.expression(scalar(Fraction(1, defaults.of(number).divisor), number))
        return [*rates[:growing], *(rate * unit for rate in rates[growing:])]

    rates, constant_rates = rates_at(x, k), tuple[int, ...]()
    stepped = list(zip(x, rates, strict=True))
    if equations.tangents:
        stepped += _tangents(equations, rates_at, x, rates)
        options["compact_mode"] = not equations.lanes or equations.tangents > 1
    else:
        constant_rates = tuple(i for i, rate in enumerate(rates) if rate == EXPRESSIONS.zero)
        inside = list(x)
        for parameter, column in enumerate(constant_rates, first + len(pattern)):
            inside[column] = hy.par[parameter]
        stepped = list(zip(x, rates_at(inside, k) if constant_rates else rates, strict=True))
    tolerance, scale = equations.tolerance, 0.0
    if tolerance is not None and equations.order:
        least = _tolerance_of(equations.order)
        stepped.append((hy.make_vars("scale"), EXPRESSIONS.zero))
        tolerance, scale = Fraction(least), float(tolerance) / least
    if tolerance is not None:
        options["tol"] = scalar(tolerance, number)
    with disk_cache(number):
        if watcher is not None:
            parameters = {name: hy.par[i] for i, name in enumerate(pattern, DESK)}
            events, desk = watcher.attach(x, rates, parameters)
            options["nt_events"] = events
            options |= compact_beyond(LONG, [event.expression for event in events])
        away = None if distance is None else distance(x, k, EXPRESSIONS)
        if away is not None:
            options["t_events"] = [terminal_event(away, number)]
        heyoka = integrator(stepped, number, equations.lanes, **options)
    count = len(pattern) * (1 + equations.driven)
    kind = CompiledBatch if equations.lanes else Engine
    return kind(heyoka, number, first, count, constant_rates, desk, scale)


def order_of(tolerance: float) -> int:
    """The order that heyoka chooses for a tolerance (Jorba & Zou, Exp. Math. 14, 2005, 99-117)."""
    return math.ceil(1 - math.log(tolerance) / 2)


def _tolerance_of(order: int) -> float:
    """The largest tolerance, nearly, for which heyoka chooses an order.

    Steps of that order are as accurate as a larger tolerance asks where a variable that never moves
    stands beside the others: heyoka's errors are relative to the largest one.  It is as many times
    1 as the two tolerances are apart; where the state is larger than that, steps are shorter than
    need be.
    """
    return math.exp(2 * (1 - order)) * (1 + 2.0**-30)


def integrator(
    system: Sequence[tuple[Expression, Expression]],
    number: NumberType = DOUBLE,
    lanes: int = 0,
    **options: Any,
) -> HeyokaIntegrator:
    """heyoka's integrator of variables and their rates, at zero; nothing else makes any."""
    options, equations = type_options(number) | options, list(system)
    with disk_cache(number):
        if lanes:
            return hy.taylor_adaptive_batch(equations, np.zeros((len(equations), lanes)), **options)
        zeros = [scalar(Fraction(0), number)] * len(equations)
        return hy.taylor_adaptive(equations, array(zeros, number), **options)


def _tangents(
    of: Equations, rates_at: Rates, x: Sequence[Expression], rates: Sequence[Expression]
) -> list[tuple[Expression, Expression]]:
    """Variables and rates of tangents, by symbolic differentiation."""
    jacobian = [[hy.diff(rate, variable) for variable in x] for rate in rates]
    pairs = []
    for j in range(of.tangents):
        u = hy.make_vars(*(f"{name}_{j}" for name in of.columns))
        along = [_product(row, u) for row in jacobian]
        drive = j - (of.tangents - of.driven)
        if drive >= 0:
            driven = rates_at(x, of.coefficients((1 + drive) * len(of.pattern)))
            for i in range(len("pqr")):  # gamma' has no coefficients
                along[i] = along[i] + driven[i]
        pairs += list(zip(u, along, strict=True))
    return pairs


def _product(row: Sequence[Expression], u: Sequence[Expression]) -> Expression:
    """A row of the Jacobian times a tangent; an entry that is zero is no term."""
    return hy.sum([a * b for a, b in zip(row, u, strict=True) if a != EXPRESSIONS.zero])


# --- events ---------------------------------------------------------------------------------------
#
# What is known here of those who look for events in a run under way.


class Listener(Protocol):
    """Who is told what heyoka meets."""

    def met(self, k: int, order: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """heyoka met a zero of expression k, or in lane k (0), or of its rate (1), at t in the last
        step."""


class Desk:
    """What belongs to an integrator with events, whichever run takes it up.

    ``watch``: is told of them, that of the run that sat down here last (Watch.sit_down).
    ``jets``: of each expression, compiled: see :class:`polhode.taylor.event_functions.Jet`.
    """

    def __init__(self) -> None:
        self.watch: Listener | None = None
        self.jets: list[CompiledFunction] = []


class EventWatcher(Listener, Protocol):
    """What looks for events while a run is under way (polhode.taylor.event_watch.Watch)."""

    @property
    def key(self) -> Hashable:
        """What tells its events from others along the same equations."""

    @property
    def damping(self) -> Sequence[Fraction]:
        """Numbers that an integrator with its events takes as parameters, one for each."""

    def attach(
        self,
        variables: Sequence[Expression],
        rates: Sequence[Expression],
        pattern: Mapping[str, Expression],
    ) -> tuple[list[HeyokaEvent], Desk]:
        """heyoka's events for an integrator about to be built, in its variables; and their desk.

        ``rates``: with the integrator's parameters, which its events share with its equations.
        ``pattern``: those of the desk's functions, by the names of the coefficients.
        """

    def disturbed(self, state: Array, moved: Array) -> bool:
        """Whether moving the first components of the state there would disturb an event."""


# --- engine ---------------------------------------------------------------------------------------


class Engine:
    """heyoka's integrator, and what its parameters are.

    ``heyoka``: the integrator itself, ``state`` and ``parameters``: views of its memory.  From the
    parameter ``first`` on stand the ``coefficients``; behind them are ``kept``, the columns that
    the equations keep, as far as any rate asks for them.  ``desk``: of its events, where it looks
    for any.  ``scale``: what stands behind the ``columns`` of the state where the order is another
    than heyoka's own, 0 where it is not.  ``singular``: whether it ends near a form's singular set.
    """

    def __init__(
        self,
        heyoka: HeyokaIntegrator,
        number: NumberType = DOUBLE,
        first: int = 0,
        coefficients: int = 0,
        constant_rates: tuple[int, ...] = (),
        desk: Desk | None = None,
        scale: float = 0.0,
    ) -> None:
        self.heyoka, self.number, self.desk = heyoka, number, desk
        self.columns = len(heyoka.state) - (scale != 0)
        self.state, self.parameters = heyoka.state[: self.columns], heyoka.pars
        self._scale, self._behind = scale, heyoka.state[self.columns :]
        used = max(0, len(self.parameters) - first)  # no rate asks for those after
        self.first, self.after = first, first + min(used, coefficients)
        self.kept = tuple(enumerate(constant_rates[: first + used - self.after], self.after))
        self.singular = bool(heyoka.t_events) if heyoka.with_events else False
        self.key: Hashable = None  # what tells it from others that are idle
        self._zero = scalar(0, number)

    def begin(self, coefficients: Numbers | None = None) -> None:
        """Be at time 0 in the state that was written to :attr:`state`.

        With these coefficients, or those from before.
        """
        self.heyoka.time = self._zero
        if coefficients is not None and self.after > self.first:
            self.parameters[self.first : self.after] = coefficients[: self.after - self.first]
        if self._scale:
            self._behind[0] = self._scale  # steps that are not finite leave nan there
        if self.singular:
            self.heyoka.reset_cooldowns()  # traces of a run that ended there
        if self.kept:
            self.tell_kept()

    def damp(self, factors: Array) -> None:
        """See its events smaller by these factors, as far as they need any."""
        damping = self.parameters[CLOCK : self.first]
        damping[:] = factors[: len(damping)]

    def tell_kept(self) -> None:
        """Give the rates the variables that the equations keep, from where they stand."""
        for parameter, column in self.kept:
            self.parameters[parameter] = self.state[column]

    def until(self, end: HeyokaNumber, most: int, block: int) -> tuple[Outcome, int]:
        """Go on to a time in at most so many steps: how it ended, and the steps taken.

        Between two blocks of so many steps a signal is heard.
        """
        ended, steps_taken, left = Outcome.STEP_LIMIT, 0, most
        while ended is Outcome.STEP_LIMIT and left > 0:  # to heyoka 0 is no limit
            result = self.heyoka.propagate_until(end, max_steps=min(block, left))
            ended, steps = self.ended(result)
            steps_taken, left = steps_taken + steps, left - block
        return ended, steps_taken

    def ended(self, result: Any) -> tuple[Outcome, int]:
        """How heyoka's call ended, and the steps that it took."""
        return ending(result[0]), int(result[3])

    @property
    def now(self) -> HeyokaNumber:
        """The time reached."""
        return self.heyoka.time

    def grid(self, times: list[HeyokaNumber], most: int) -> tuple[Array, int, Outcome]:
        """Go on through times, the first of them now: states at the others met, steps, ending."""
        result = self.heyoka.propagate_grid(array(times, self.number), max_steps=most)
        rows: Array = result[-1][1:, : self.columns]
        return rows, int(result[3]), ending(result[0])

    def polynomials(self, end: HeyokaNumber, most: int) -> tuple[Outcome, HeyokaOutput]:
        """Go on to a time in at most so many steps: how it ended, and the continuous output."""
        result = self.heyoka.propagate_until(end, max_steps=most, c_output=True)
        return ending(result[0]), result[4]

    def release(self) -> None:
        """Leave it to the next user of such equations; the last call of all."""
        if self.desk is not None:
            self.desk.watch = None  # which knows a run, its scene and its times
        if self.key is None:
            return
        engines = IDLE.pop(self.key, [])
        engines.append(self)
        IDLE[self.key] = engines  # behind all others
        while sum(map(len, list(IDLE.values()))) > MOST:
            for oldest in list(IDLE)[:1]:
                engines = IDLE.get(oldest, [])
                del engines[:1]
                if not engines:
                    IDLE.pop(oldest, None)


class CompiledBatch(Engine):
    """A batch of doubles: states and parameters a column for each lane."""

    def begin(self, coefficients: Numbers | None = None) -> None:
        """All lanes at time 0 where they stand, see :meth:`Engine.begin`."""
        self.heyoka.set_time(0.0)
        if coefficients is not None and self.after > self.first:
            self.parameters[self.first : self.after] = coefficients[: self.after - self.first]
        if self._scale:
            self._behind[0] = self._scale
        if self.kept:
            self.tell_kept()

    def ended(self, _: Any) -> tuple[Outcome, Any]:
        """How the lane ended that came least far, and the steps of each."""
        results = self.heyoka.propagate_res
        outcomes = {ending(result[0]) for result in results}
        least = (x for x in (Outcome.NON_FINITE, Outcome.STEP_LIMIT) if x in outcomes)
        return next(least, Outcome.REACHED_END), np.array([result[3] for result in results])

    @property
    def now(self) -> HeyokaNumber:
        """The time that all lanes have reached."""
        return min(self.heyoka.time, key=abs)

    def grid(self, times: list[HeyokaNumber], most: int) -> tuple[Array, Any, Outcome]:
        """The same of all lanes, which stand at one time: states at times that all of them met."""
        grid = np.repeat(np.array([times]).T, self.state.shape[1], axis=1)
        rows = self.heyoka.propagate_grid(grid, max_steps=most)[1][1:, : self.columns]
        outcome, taken = self.ended(None)
        return rows[~np.isnan(rows[:, 0]).any(axis=1)], taken, outcome


# --- idle engines ---------------------------------------------------------------------------------
#
# Engines come back in garbage collections, too, below any lock of the thread that collects: so
# there is no lock.  No two threads are given the same engine, for a list is never copied; one that
# comes back while another thread puts one of the same key may be lost, and is built again.


COMPILING = Lock(LockPlace.COMPILING)
#: Kinds that are worked with by turns, and each thread's engine of a sweep.  One with an event
#: takes 5 megabytes, or 15 where it was compiled in this process.  Of more than so many those go
#: first whose key was not used for longest.
MOST = max(16, os.cpu_count() or 1)
#: Engines that nobody uses at the moment, by their key.
IDLE: dict[Hashable, list[Any]] = {}


def lent(key: Hashable, build: Callable[[], Engine] | None = None, wait: bool = True) -> Engine:
    """An engine of what a key tells from others: from now on the caller's, who releases it.

    Where none is idle it is built, in the principal form from a key that is Equations, or as
    ``build`` does.  One thread at a time builds, since the code that heyoka has compiled serves the
    others; not so without ``wait``, for those that may hold a precision.
    """
    try:
        engine: Engine = IDLE[key].pop()
        return engine
    except (KeyError, IndexError):
        pass
    with COMPILING.held() if wait else nullcontext():
        with suppress(KeyError, IndexError):  # another thread's
            engine = IDLE[key].pop()
            return engine
        engine = built(cast(Equations, key)) if build is None else build()
    engine.key = key
    return engine
