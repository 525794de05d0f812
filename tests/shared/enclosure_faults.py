"""Faults for the untrusted parts of the enclosures: whatever they do, no ball may be wrong."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from polhode.enclosures import approximation
from polhode.enclosures.task import Untrusted

#: Ways of writing into an array.
WRITES: tuple[Callable[[Any], Any], ...] = (
    lambda x: np.multiply(x, 0, out=x),
    lambda x: np.negative(x, out=x),
    lambda x: np.multiply(x, 1.0 + 1e-9, out=x, casting="unsafe"),
    lambda x: x.flat.__setitem__(0, 1000),
)


def arrays(thing: Any) -> list[Any]:
    """All arrays in a value, and in what it is made of."""
    if isinstance(thing, np.ndarray):
        return [thing]
    if isinstance(thing, (list, tuple)):
        return [x for part in thing for x in arrays(part)]
    return arrays(list(vars(thing).values())) if hasattr(thing, "__dataclass_fields__") else []


class Hoard:
    """Arrays that a faulty part was given or has returned, written into at any later call."""

    def __init__(self, rng: random.Random, often: float = 0.3) -> None:
        self.rng, self.often = rng, often
        self.kept: list[Any] = []

    def around(self, honest: Callable[..., Any]) -> Callable[..., Any]:
        """The same part, which writes into what is kept and keeps all that it comes to see."""

        def faulty(*given: Any) -> Any:
            self.write(self.kept)
            found = honest(*given)
            self.write(arrays(given))
            self.kept = [*arrays(given), *arrays(found), *self.kept][:40]
            return found

        return faulty

    def write(self, into: Sequence[Any]) -> None:
        """Some of them overwritten."""
        for array in into:
            if array.flags.writeable and array.size and self.rng.random() < self.often:
                self.rng.choice(WRITES)(array)


def hoarder(rng: random.Random) -> Untrusted:
    """Parts that are right, write into their arguments, keep their results and change them."""
    hoard = Hoard(rng, rng.choice((0.03, 0.3)))
    honest = Untrusted()
    return Untrusted(*map(hoard.around, (honest.window, honest.matrices, honest.correction)))


#: How large an alteration is, relative to what is altered.
SIZES = (1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.5, 3.0)


def random_fault(rng: random.Random) -> tuple[str, Untrusted]:
    """A fault in one of the untrusted parts, in every window or in some, and its name."""
    if rng.random() < 0.2:
        return "all: hoards and writes", hoarder(rng)
    part, name, fault = rng.choice(FAULTS)
    often = rng.choice((1.0, 0.3))
    honest = getattr(Untrusted(), part)

    def faulty(*given: Any) -> Any:
        if rng.random() > often:
            return honest(*given)
        return fault(rng, honest, *given)

    return f"{part}: {name}", replace(Untrusted(), **{part: faulty})


def _somewhere(rng: random.Random, values: Any) -> tuple[int, ...]:
    return tuple(rng.randrange(n) for n in values.shape)


def _altered(rng: random.Random, values: Any) -> Any:
    """One number altered by a part of the largest of its step, or by a part of itself."""
    place, by = _somewhere(rng, values), rng.choice(SIZES) * rng.choice((-1, 1))
    found = values.copy()
    own = rng.random() < 0.5
    found[place] += by * (found[place] if own else np.max(np.abs(values[place[0]])))
    return found


def _with(values: Any, place: Any, value: float) -> Any:
    found = values.copy()
    found[place] = value
    return found


def _normal(rng: random.Random, shape: tuple[int, ...]) -> Any:
    return np.random.default_rng(rng.randrange(2**32)).standard_normal(shape)


def _not_a_number(rng: random.Random, values: Any) -> Any:
    return _with(values, _somewhere(rng, values), rng.choice((np.nan, np.inf, -np.inf, 1e300)))


def _start(rng: random.Random, values: Any) -> Any:
    """The constant terms alone: a start, a V(0)."""
    found = values.copy()
    place = _somewhere(rng, values[:, 0])
    found[place[0], 0][place[1:]] += rng.choice(SIZES)
    return found


CHANGES = {
    "one number": _altered,
    "a step zeroed": lambda rng, x: _with(x, rng.randrange(len(x)), 0.0),
    "all scaled": lambda rng, x: x * rng.choice((0.0, 0.5, 1.0 + 1e-6, 2.0, -1.0)),
    "noise": lambda rng, x: x * (1.0 + rng.choice(SIZES) * _normal(rng, x.shape)),
    "not a number": _not_a_number,
    "coefficients reversed": lambda _, x: x[:, ::-1].copy(),
    "steps reversed": lambda _, x: x[::-1].copy(),
    "a constant term": _start,
}


def _of_result(change: Callable[..., Any]) -> Callable[..., Any]:
    return lambda rng, honest, *given: change(rng, honest(*given))


def _of_series(change: Callable[..., Any]) -> Callable[..., Any]:
    def fault(rng: random.Random, honest: Any, *given: Any) -> Any:
        found = honest(*given)
        return None if found is None else found._replace(series=change(rng, found.series))

    return fault


def _wrong_body(rng: random.Random, honest: Any, problem: Any, *given: Any) -> Any:
    """heyoka's run and the series with one constant wrong."""
    factors = list(problem.factors)
    factors[rng.randrange(9)] += rng.choice(SIZES)
    return honest(replace(problem, factors=tuple(factors)), *given)


def _wrong_start(rng: random.Random, honest: Any, problem: Any, state: Any, *given: Any) -> Any:
    """heyoka's run from another state."""
    centre = list(state.centre)
    centre[rng.randrange(6)] += int(rng.choice(SIZES) * 2.0**50) << (problem.fine - 50)
    return honest(problem, replace(state, centre=tuple(centre)), *given)


def _odd_grid(rng: random.Random, honest: Any, *given: Any) -> Any:
    """The times of the grid moved, the series as they were: right for other times."""
    found = honest(*given)
    if found is None or len(found.times) < 3:
        return found
    times = list(found.times)
    n = rng.randrange(1, len(times) - 1)
    times[n] = (times[n - 1] + times[n + 1]) // 2
    return found._replace(times=tuple(times))


def _long_steps(rng: random.Random, honest: Any, *given: Any) -> Any:
    kept = approximation.MOST_TURN
    approximation.MOST_TURN = rng.choice((0.1, 8.0, 20.0))
    try:
        return honest(*given)
    finally:
        approximation.MOST_TURN = kept


def _few_terms(rng: random.Random, honest: Any, *given: Any) -> Any:
    kept = approximation.LEAST_TERM
    approximation.LEAST_TERM = rng.choice((1e-2, 1e-5, 1e-9))
    try:
        return honest(*given)
    finally:
        approximation.LEAST_TERM = kept


FAULTS: list[tuple[str, str, Callable[..., Any]]] = [
    *(("matrices", name, _of_result(change)) for name, change in CHANGES.items()),
    *(("correction", name, _of_result(change)) for name, change in CHANGES.items()),
    *(("window", name, _of_series(change)) for name, change in CHANGES.items()),
    ("window", "wrong constant", _wrong_body),
    ("window", "wrong start", _wrong_start),
    ("window", "odd grid", _odd_grid),
    ("window", "steps of another length", _long_steps),
    ("matrices", "too few terms", _few_terms),
]
