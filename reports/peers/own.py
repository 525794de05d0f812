"""polhode prepared as the other programs are: a propagator, or runs of a scene made anew each time.

``integrate``: a scene with another start is made for each call, and run: what a loop over starts
in Python pays for trajectories.  ``extended``: a propagator in extended precision, of
the exact numbers of a draw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from kit import DOUBLE, EXTENDED
from peers.field import Run, Top
from programs import PROJECTED

UPRIGHT = np.array([0.0, 0.0, 1.0])
_LARGEST = 1000  # denominator of a draw's numbers


def prepared(present: Sequence[bool], method: str) -> Run:
    """A propagator of each body and tolerance; or a scene of each body at the times asked for.

    ``present``: unused, polhode finds out itself what vanishes.  What is made of a body is kept
    with it: a loop over starts has it at hand.
    """
    propagators: dict[tuple[int, float], tuple[Top, polhode.Propagator]] = {}
    scenes: dict[tuple[int, int, float], tuple[Top, polhode.Scene]] = {}
    number = EXTENDED if method == "extended" else DOUBLE

    def propagated(top: Top, start: Any, at: Any, tol: float) -> Any:
        body, go = propagators.get((id(top), tol), (None, None))
        if go is None or body is not top:
            scene, tolerance = _scene(top, 2, 1.0, start[3:]), _tolerance(tol, number)
            go = polhode.propagator(
                scene, number=number.name, tol=tolerance, project=tol == PROJECTED
            )
            propagators[id(top), tol] = top, go
        if number is EXTENDED:
            start = np.array([np.longdouble(x.numerator) / x.denominator for x in _exact(start)])
        if len(at) == 2:
            return go(start, t=float(at[1]))[None]
        return go(start, t=at)

    def integrated(top: Top, start: Any, at: Any, tol: float) -> Any:
        end = float(at[-1])
        body, scene = scenes.get((id(top), len(at), end), (None, None))
        if scene is None or body is not top:
            scene = _scene(top, len(at), end, start[3:])
            scenes[id(top), len(at), end] = top, scene
        p, q, r = map(Fraction, start[:3].tolist())
        run = polhode.integrate(replace(scene, omega=(p, q, r)), tol=_tolerance(tol))
        return run.states if len(at) > 2 else run.states[-1:]

    return integrated if method == "integrate" else propagated


def prepared_many(present: Sequence[bool], method: str) -> Run:
    """Arrays of starts to a propagator of each body and tolerance, or to integrate_many.

    In one thread; ``present``: unused.
    """
    propagators: dict[tuple[int, float], tuple[Top, polhode.Propagator]] = {}

    def propagated(top: Top, start: Any, at: Any, tol: float) -> Any:
        body, go = propagators.get((id(top), tol), (None, None))
        if go is None or body is not top:
            go = polhode.propagator(_scene(top, 2, 1.0, UPRIGHT), tol=_tolerance(tol))
            propagators[id(top), tol] = top, go
        return go(start, t=float(at[-1]), workers=1)

    def integrated(top: Top, start: Any, at: Any, tol: float) -> Any:
        scene, end = _scene(top, 2, 1.0, UPRIGHT), float(at[-1])
        many = polhode.integrate_many(scene, starts=start, at=[end], tol=_tolerance(tol), workers=1)
        return many.states[:, 0]

    return propagated if method == "propagator" else integrated


def _tolerance(tol: float, number: polhode.NumberType = DOUBLE) -> float | None:
    """A tolerance as it is asked for: none at all for the type's eps."""
    return None if tol <= float(number.eps) else tol


def _exact(values: Any) -> list[Fraction]:
    """The short fractions that were rounded to doubles, where there are; else the doubles."""
    exact = [Fraction(x) for x in values.tolist()]
    near = [x.limit_denominator(_LARGEST) for x in exact]
    return [y if float(y) == float(x) else x for x, y in zip(exact, near, strict=True)]


def _scene(top: Top, count: int, end: float, gamma: Any) -> polhode.Scene:
    """A scene of the body at even times; gamma of length 1 exactly, as every draw's is."""
    pull = top.torque.tolist()
    heavy = any(pull)
    return polhode.top(
        moments=_exact(top.moments),
        centre=_exact(top.torque) if heavy else None,
        weight=1 if heavy else 0,
        omega=[1, 0, 0],
        gamma=_exact(gamma),
        end=end,
        samples=count,
    )
