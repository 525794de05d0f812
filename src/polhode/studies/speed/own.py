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
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.studies.speed.draws import times

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
    omega = tuple(map(Fraction, start[:3].tolist()))
    run = integrate(replace(scene, omega=omega), tol=None if tol == 2.0**-52 else tol)
    return run.states if len(at) > 2 else run.states[-1:]


def _key(top: Top) -> tuple[bytes, bytes]:
    return top.moments.tobytes(), top.torque.tobytes()


@cache
def _scene(moments: bytes, torque: bytes) -> Scene:
    """A scene of the body that doubles tell."""
    import numpy as np

    principal, pull = (tuple(map(Fraction, np.frombuffer(x).tolist())) for x in (moments, torque))
    body = Body.of_moments(principal, pull, int(any(pull)))
    return Scene(body, (1, 0, 0), (0, 0, 1), name="contest")


@cache
def _propagator(moments: bytes, torque: bytes, tol: float) -> Propagator:
    return propagator(_scene(moments, torque), tol=None if tol == 2.0**-52 else tol)


@cache
def _timed(
    moments: bytes, torque: bytes, count: int, end: float, gamma: tuple[float, ...]
) -> Scene:
    """The body's scene at even times; gamma of length 1 exactly, as every draw's is."""
    unit = tuple(Fraction(x).limit_denominator(_LARGEST) for x in gamma)
    at = times(int(end), count)
    return replace(_scene(moments, torque), gamma=unit, times=at)
