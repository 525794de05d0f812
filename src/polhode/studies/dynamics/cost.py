"""What a crossing costs: batches with an event beside other programs, all in this process.

Every program follows orbits of one body on one level, makes its crossings of the section at maxima
of |G|, and is judged on the first of them, a regular orbit, by a run in quad.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from fractions import Fraction
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from polhode.dynamics.sections import coordinates as geometry
from polhode.dynamics.sections.section import section
from polhode.equations.forms import principal
from polhode.judging.adaptive_precision import integrate
from polhode.numbers.conversion import exactly, to_double
from polhode.peers.field import TERMS, returning
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies.row_filter import Only

CASE = "general/asymmetric-regular"
CROSSINGS, ORBITS = 200, 48
TOLERANCE = 1e-13  # of the others, relative and absolute
ROUNDS = 3
OURS = ("polhode, one orbit", "polhode, batches")

#: Times of an orbit's crossings up to a time, from its start.
Crossed = Callable[[Any, float], Any]


def rows(quick: bool, wanted: Only, tick: Callable[[str], None]) -> Iterator[dict[str, Any]]:
    """A row a program: microseconds a crossing, error of the last crossing's time."""
    scene = library.load(CASE)
    on = geometry.ground(scene, scene.integrals.energy, _area(scene))
    count = 10 if quick else CROSSINGS
    ours = section(scene, starts="scene", crossings=count)
    end = float(ours.times[0, -1])
    beside = False
    for name, make in _others(scene, on).items():
        if not wanted(f"cost {name}"):
            continue
        tick(f"cost, {name}")
        known: dict[str, Any] = {"program": name, "case": CASE, "end": round(end, 1)}
        try:
            solve = make()
        except ImportError as missing:
            yield known | {"outcome": f"{missing.name} is not installed"}
            continue
        beside = True
        solve(ours.start_states[0], end / 10)  # compiles, where there is something to compile
        seconds, times = np.inf, np.zeros(0)
        for _ in range(1 if quick else ROUNDS):
            began = time.process_time()
            times = solve(ours.start_states[0], end + 1e-3)
            seconds = min(seconds, time.process_time() - began)
        yield known | _judged(scene, on, times, seconds, 1)
    if wanted(*(f"cost {name}" for name in OURS)) or beside:
        tick("cost, polhode")
        yield from _ours(scene, on, ours, quick)


def versions() -> dict[str, str]:
    """Those of the other programs that are there."""
    found = {}
    for name in ("scipy", "CyRK", "numba"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _ours(scene: Scene, on: geometry.Ground, one: Any, quick: bool) -> Iterator[dict[str, Any]]:
    """One orbit alone, and many in batches; with digits, too."""
    count = one.times.shape[1]
    grid = {"starts": "scene"}, {"grid": (8, ORBITS // 8)}
    for asked, name in zip(grid, OURS, strict=True):
        section(scene, crossings=2, workers=1, **asked)  # type: ignore[arg-type]
        seconds, told, found = np.inf, np.inf, one
        for _ in range(1 if quick else ROUNDS):
            began = time.process_time()
            found = section(scene, crossings=count, workers=1, **asked)  # type: ignore[arg-type]
            middle = time.process_time()
            assert found.digits.shape == found.times.shape
            seconds = min(seconds, middle - began)
            told = min(told, time.process_time() - middle)
        made, end = int(found.counts.sum()), round(float(np.nanmax(found.times)), 1)
        known = {"program": name, "case": CASE, "end": end}
        judged = _judged(scene, on, one.times[0], seconds, len(found.counts))
        known |= judged | {"crossings": made, "microseconds": round(1e6 * seconds / made, 2)}
        yield known | {"digits_microseconds": round(1e6 * told / made, 2)}


def _judged(
    scene: Scene, on: geometry.Ground, times: Any, seconds: float, orbits: int
) -> dict[str, Any]:
    """Crossings, microseconds each, and the error of the last one's time."""
    last = Fraction(float(times[-1]))
    (exact,) = integrate(scene, at=[last], number="quad").states
    state = np.array([[float(x) for x in exact]])
    G = [exactly(float(a)) * exactly(x) for a, x in zip(on.moments, exact[:3], strict=True)]
    a, g = [exactly(float(x)) for x in on.frame[2]], [exactly(x) for x in exact[3:]]
    value = sum(
        g[i] * (a[(i + 1) % 3] * G[(i + 2) % 3] - a[(i + 2) % 3] * G[(i + 1) % 3]) for i in range(3)
    )
    slope = geometry.momentum_slope(on, state)[0] / on.weight
    return {
        "outcome": "done",
        "orbits": orbits,
        "crossings": len(times),
        "microseconds": round(1e6 * seconds / len(times), 2),
        "error": abs(to_double(value) / slope),
    }


def _others(scene: Scene, on: geometry.Ground) -> dict[str, Callable[[], Crossed]]:
    known = principal.coefficients(scene.body)
    k = tuple(to_double(known.get(term, 0)) for term in TERMS)
    a = [float(x) for x in on.frame[2]]
    A = [float(x) for x in on.moments]

    def zero(y: Any) -> Any:
        """D: falls through zero at a maximum of |G|."""
        G = [A[i] * y[i] for i in range(3)]
        return (
            y[3] * (a[1] * G[2] - a[2] * G[1])
            + y[4] * (a[2] * G[0] - a[0] * G[2])
            + y[5] * (a[0] * G[1] - a[1] * G[0])
        )

    def scipy() -> Crossed:
        from scipy.integrate import solve_ivp

        warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
        rates = returning(k)

        def event(t: float, y: Any) -> Any:
            return zero(y)

        event.direction = -1.0  # type: ignore[attr-defined]

        def solve(start: Any, end: float) -> Any:
            found = solve_ivp(
                lambda t, y: rates(*y.tolist()),
                (0.0, end),
                start,
                method="DOP853",
                rtol=TOLERANCE,
                atol=TOLERANCE,
                events=event,
            )
            times = found.t_events[0]
            return times[times > 1e-9 * end]

        return solve

    def cyrk() -> Crossed:
        from CyRK import nbsolve2_ivp
        from CyRK.nb.numba_solver import cyjit_sig

        from polhode.peers.numba_field import rates_time_state

        field = rates_time_state(k, cyjit_sig)

        def solve(start: Any, end: float) -> Any:
            found = nbsolve2_ivp(
                field.address,
                (0.0, end),
                np.array(start),
                method="DOP853",
                dense_output=True,
                rtol=TOLERANCE,
                atol=TOLERANCE,
            )
            t, values = found.t, zero(found.y)
            falls = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
            low, high = t[falls].copy(), t[falls + 1].copy()
            one, two = values[falls].copy(), values[falls + 1].copy()
            for _ in range(40):  # the Illinois method for all at once, on the dense output
                middle = (low * two - high * one) / (two - one)
                here = zero(found.call_vectorize(middle))
                up = here > 0
                two = np.where(up, two / 2, here)
                one = np.where(up, here, one / 2)
                low, high = np.where(up, middle, low), np.where(up, high, middle)
                if np.abs(here).max(initial=0.0) < 1e-15:
                    break
            return middle

        return solve

    return {"SciPy DOP853, events": scipy, "CyRK DOP853, dense output": cyrk}


def _area(scene: Scene) -> Any:
    area = scene.integrals.area
    assert area is not None
    return area
