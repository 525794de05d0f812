"""polhode prepared as the other programs are: a propagator, or runs of a scene made anew each time.

``integrate``: a scene with another start is made for each call, and run: what a loop over starts
in Python pays for trajectories.  ``extended``: a propagator in extended precision, of
the exact numbers of a draw.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from peers.field import Run, Top
from polhode.numbers.number_types import DOUBLE, EXTENDED
from programs import PROJECTED

UPRIGHT = (0.0, 0.0, 1.0)
_LARGEST = 1000  # denominator of a draw's numbers


def _by_body(make: Callable[..., Any]) -> Callable[..., Any]:
    """What is made of a body and more, kept with the body: a loop over starts has it at hand."""
    values: dict[tuple[Any, ...], tuple[Top | None, Any]] = {}

    def value(top: Top, *key: Any) -> Any:
        body, of_body = values.get((id(top), *key), (None, None))
        if body is not top:
            of_body = make(top, *key)
            values[id(top), *key] = top, of_body
        return of_body

    return value


def prepared(present: Sequence[bool], method: str, many: bool = False) -> Run:
    """A propagator of each body and tolerance; or a scene of each body at the times asked for.

    ``present``: unused, polhode finds out itself what vanishes.  ``many``: arrays of starts to a
    propagator, or to integrate_many, in one thread.
    """
    number = EXTENDED if method == "extended" else DOUBLE
    scene_of = _by_body(_scene)

    @_by_body
    def propagator(top: Top, tol: float) -> polhode.Propagator:
        options: dict[str, Any] = {"tol": _tolerance(tol, number), "number": number.name}
        return polhode.propagator(_scene(top), project=tol == PROJECTED and not many, **options)

    def propagated(top: Top, start: Any, at: Any, tol: float) -> Any:
        go = propagator(top, tol)
        if number is EXTENDED:
            start = np.array([np.longdouble(x.numerator) / x.denominator for x in _exact(start)])
        return go(start, t=at) if len(at) > 2 else go(start, t=float(at[1]))[None]

    def integrated(top: Top, start: Any, at: Any, tol: float) -> Any:
        p, q, r, *gamma = start.tolist()
        scene = scene_of(top, len(at), float(at[-1]), tuple(gamma))
        omega = Fraction(p), Fraction(q), Fraction(r)
        run = polhode.integrate(replace(scene, omega=omega), tol=_tolerance(tol))
        return run.states if len(at) > 2 else run.states[-1:]

    def propagated_many(top: Top, start: Any, at: Any, tol: float) -> Any:
        return propagator(top, tol)(start, t=float(at[-1]), workers=1)

    def integrated_many(top: Top, start: Any, at: Any, tol: float) -> Any:
        options: dict[str, Any] = {"at": [float(at[-1])], "tol": _tolerance(tol), "workers": 1}
        return polhode.integrate_many(_scene(top), starts=start, **options).states[:, 0]

    if method == "integrate":
        return integrated_many if many else integrated
    return propagated_many if many else propagated


def _tolerance(tol: float, number: polhode.NumberType = DOUBLE) -> float | None:
    """A tolerance as it is asked for: none at all for the type's eps."""
    return None if tol <= float(number.eps) else tol


def _exact(values: Iterable[float]) -> list[Fraction]:
    """The short fractions that were rounded to doubles, where there are; else the doubles."""
    exact = [Fraction(float(x)) for x in values]
    near = [x.limit_denominator(_LARGEST) for x in exact]
    return [y if float(y) == float(x) else x for x, y in zip(exact, near, strict=True)]


def _scene(
    top: Top, count: int = 2, end: float = 1.0, gamma: Sequence[float] = UPRIGHT
) -> polhode.Scene:
    """A scene of the body at even times; gamma of length 1 exactly, as every draw's is."""
    heavy = bool(top.torque.any())
    return polhode.top(
        moments=_exact(top.moments),
        centre=_exact(top.torque) if heavy else None,
        weight=1 if heavy else 0,
        omega=[1, 0, 0],
        gamma=_exact(gamma),
        end=end,
        samples=count,
    )
