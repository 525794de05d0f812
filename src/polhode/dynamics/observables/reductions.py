"""Numbers that a motion is reduced to, asked for in words.

final            the last state
largest X        of an expression in the columns of a state, in t and theta over the output times,
smallest X       and the first of those times at which it is reached
first NAME       the first time after 0 of the scene's event NAME, and the state there
lyapunov         the largest Lyapunov exponent to the last time, as polhode.lyapunov tells it
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from polhode.common.arguments import each, of_kind
from polhode.common.errors import BadInput, nearest
from polhode.numbers import expression
from polhode.numbers.conversion import number_value
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Stack
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import READY_MADE, STATE
from polhode.taylor.event_functions import identically_zero, size_of

FINAL, LARGEST, SMALLEST, FIRST, LYAPUNOV = "final", "largest", "smallest", "first", "lyapunov"
_EXPECTED = "final, largest X, smallest X, first EVENT or lyapunov"


class Reduction(NamedTuple):
    """What is asked for, and of what: an expression, or an event's name."""

    kind: str
    of: str = ""

    @property
    def text(self) -> str:
        """As it was asked for."""
        return f"{self.kind} {self.of}".strip()

    def names(self, columns: Sequence[str]) -> tuple[str, ...]:
        """Names of its numbers, of states with these columns."""
        if self.kind == FINAL:
            return tuple(f"final {name}" for name in columns)
        if self.kind == FIRST:
            return (f"t of {self.text}", *(f"{name} at {self.text}" for name in columns))
        if self.kind == LYAPUNOV:
            return LYAPUNOV, "lyapunov uncertainty", "lyapunov growth"
        return self.text, f"t of {self.text}"


def asked(scene: Scene, keep: Any) -> tuple[Reduction, ...]:
    """Reductions from their words, each once; raises BadInput."""
    if isinstance(keep, str):
        keep = (keep,)

    texts = each(scene.name, "keep", keep, lambda text: text, _EXPECTED)
    for text in texts:
        of_kind(scene.name, "keep", text, str, _EXPECTED)
    found = tuple(dict.fromkeys(_read(scene, text) for text in texts))
    if not found:
        raise BadInput(scene.name, "keep", None, _EXPECTED)
    return found


def event_of(scene: Scene, name: str) -> Event:
    """An event by its name: the scene's, or one known by name; raises BadInput."""
    events = {known: Event(known) for known in READY_MADE}
    events |= {event.name: event for event in scene.events}
    if name not in events:
        raise BadInput(scene.name, f"keep: {FIRST}", name, f"an event: {nearest(name, [*events])}")
    event = events[name]
    if event.expression is None or not size_of(scene, event).entire:
        expected = "an event with an expression, without roots and division by a variable"
        raise BadInput(scene.name, f"keep: {FIRST}", name, expected)
    if identically_zero(event.expression, (*scene.columns, "t")):
        expected = f"an event that is not zero everywhere, as {event.expression} is"
        raise BadInput(scene.name, f"keep: {FIRST}", name, expected)
    return event


def extremes(
    which: Sequence[Reduction],
    states: Stack,
    times: Stack,
    columns: Sequence[str],
    kind: NumberType,
) -> dict[str, Any]:
    """What states (members, times, columns) tell: arrays by name, one number per member."""
    found: dict[str, Any] = {}
    with np.errstate(all="ignore"):
        for what in which:
            names = what.names(columns)
            if what.kind == FINAL:
                found |= zip(names, states[:, -1].T, strict=True)
            else:
                values = _values(what.of, states, times, columns, kind)
                at = (np.argmax if what.kind == LARGEST else np.argmin)(values, axis=1)
                best = np.take_along_axis(values, at[:, None], axis=1)[:, 0]
                found |= zip(names, (best, times[at]), strict=True)
    return found


def _values(
    text: str, states: Stack, times: Stack, columns: Sequence[str], kind: NumberType
) -> Any:
    """An expression at all times of all members."""
    names: dict[str, Any] = {name: states[:, :, i] for i, name in enumerate(columns)}
    if "gamma3" in names:
        across = np.hypot(names["gamma1"], names["gamma2"])
        names["theta"] = np.arctan2(across, names["gamma3"])
    names["t"] = np.broadcast_to(times, states.shape[:2])
    functions = {"sqrt": np.sqrt, "sin": np.sin, "cos": np.cos}
    value = expression.evaluate(text, names, Algebra(lambda x: number_value(x, kind), functions))
    return np.broadcast_to(value, states.shape[:2])


def _read(scene: Scene, text: str) -> Reduction:
    kind, _, of = text.strip().partition(" ")
    of = " ".join(of.split())
    if kind in (FINAL, LYAPUNOV) and not of:
        return Reduction(kind)
    if kind == FIRST and of:
        event_of(scene, of)
        return Reduction(kind, of)
    if kind in (LARGEST, SMALLEST) and of:
        sample = {name: np.full((1, 1), 0.5 + 0.1 * STATE.index(name)) for name in scene.columns}
        states = np.stack(list(sample.values()), axis=2)
        try:
            _values(of, states, np.ones(1), scene.columns, DOUBLE)
        except ExpressionError as fault:
            raise BadInput(scene.name, f"keep: {kind}", of, f"an expression ({fault})") from None
        return Reduction(kind, of)
    raise BadInput(scene.name, "keep", text, _EXPECTED)
