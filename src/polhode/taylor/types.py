"""heyoka's things by kind: it brings no types along, and these names say what is meant."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

from polhode.equations.form import Form
from polhode.motion.outcomes import Projection
from polhode.numbers.number_types import Array, Functions, Scalar

#: float, numpy.longdouble, heyoka.real128 or heyoka.real, by the number type of the run.
HeyokaNumber: TypeAlias = Any

#: heyoka.expression, of variables, parameters and the time.
Expression: TypeAlias = Any

#: heyoka.taylor_adaptive, or taylor_adaptive_batch: compiled code, state and time of a system.
HeyokaIntegrator: TypeAlias = Any

#: heyoka.nt_event or t_event, and their batch kinds.
HeyokaEvent: TypeAlias = Any

#: heyoka.taylor_outcome: how steps ended.
HeyokaOutcome: TypeAlias = Any

#: heyoka.continuous_output: the polynomials of some steps.
HeyokaOutput: TypeAlias = Any

#: heyoka.cfunc: compiled code of some expressions.
CompiledFunction: TypeAlias = Any


# --- protocols ------------------------------------------------------------------------------------
#
# What integrates, what looks for events, what puts the state back: what each asks of the others.
#
# Whoever builds an integrator gives it its watcher and its corrector, and gives the corrector the
# watcher; none of the three reaches for one through another. No heyoka is needed to name them.


class Rates(Protocol):
    """What gives rates to variables (polhode.taylor.system.System)."""

    @property
    def form(self) -> Form:
        """The form of the equations."""

    def field(
        self, state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> list[Scalar]:
        """The rates, by the coefficients' names."""


class Listener(Protocol):
    """Who is told what heyoka meets."""

    def met(self, k: int, order: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """heyoka met a zero of expression k, or in lane k (0), or of its rate (1), at t in the last
        step."""


class Desk:
    """What belongs to an integrator with events, whichever run takes it up: ``watch`` is told of
    them.

    ``jets``: of each expression, compiled: see :class:`polhode.taylor.event_functions.Jet`.
    """

    def __init__(self) -> None:
        self.watch: Listener | None = None
        self.jets: list[CompiledFunction] = []


class Watcher(Listener, Protocol):
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


class Corrector(Protocol):
    """What puts the state back now and then (polhode.taylor.projection,
    .unit_norm)."""

    @property
    def every(self) -> int:
        """Steps between two corrections."""

    @property
    def seconds(self) -> float:
        """The time spent on compiling."""

    def correct(self, state: Array) -> bool:
        """Correct a state, heyoka's numbers, where it stands; False: try again a step later."""

    @property
    def projection(self) -> Projection:
        """What was corrected so far."""
