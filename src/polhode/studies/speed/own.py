"""polhode prepared as the other programs are: a propagator, or runs of a scene made anew each time.

``integrate``: a scene with another start is made for each call, and run: what a loop over starts
in Python pays for trajectories.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

from polhode.judging.adaptive_precision import integrate
from polhode.peers.prepared import Run, Top
from polhode.runs.propagator import Propagator, propagator
from polhode.scenes.from_numbers import top as scene_of
from polhode.scenes.scene import Scene
from polhode.studies.speed.programs import EPS, PROJECTED

_LARGEST = 1000  # denominator of a draw's gamma


def prepared(present: Sequence[bool], method: str) -> Run:
    """A propagator of each body and tolerance; or a scene of each body at the times asked for.

    ``present``: unused, polhode finds out itself what vanishes.
    """
    return _propagated if method == "propagator" else _integrated


def _propagated(top: Top, start: Any, at: Any, tol: float) -> Any:
    go = _propagator(*_key(top), tol)
    if len(at) == 2:
        return go(start, t=float(at[1]))[None]
    return go(start, t=at)


def _integrated(top: Top, start: Any, at: Any, tol: float) -> Any:
    scene = _timed(*_key(top), len(at), float(at[-1]), tuple(start[3:].tolist()))
    p, q, r = map(Fraction, start[:3].tolist())
    run = integrate(replace(scene, omega=(p, q, r)), tol=_told(tol))
    return run.states if len(at) > 2 else run.states[-1:]


def _key(top: Top) -> tuple[bytes, bytes]:
    return top.moments.tobytes(), top.torque.tobytes()


def _told(tol: float) -> float | None:
    """A tolerance as it is asked for: none at all for eps."""
    return None if tol <= EPS else tol


@cache
def _propagator(moments: bytes, torque: bytes, tol: float) -> Propagator:
    scene = _timed(moments, torque, 2, 1.0, (0.0, 0.0, 1.0))
    return propagator(scene, tol=_told(tol), project=tol == PROJECTED)


@cache
def _timed(
    moments: bytes, torque: bytes, count: int, end: float, gamma: tuple[float, ...]
) -> Scene:
    """A scene of the body at even times; gamma of length 1 exactly, as every draw's is."""
    import numpy as np

    principal, pull = (np.frombuffer(x).tolist() for x in (moments, torque))
    heavy = any(pull)
    return scene_of(
        moments=principal,
        centre=pull if heavy else None,
        weight=1 if heavy else 0,
        omega=[1, 0, 0],
        gamma=[Fraction(x).limit_denominator(_LARGEST) for x in gamma],
        end=end,
        samples=count,
    )
