"""Rows of propagators of random bodies, starts, tolerances and times, beside runs in quad.

``python tests/campaigns/loose_rows.py [SECONDS] [SEED]`` prints, for each way a call can go, the
errors over the tolerance: of gamma, and of omega over the bound of the rate; and the worst calls.

Last printed, in 100 seconds of a busy machine, with seed 77:

    4233 rows
    heyoka's own: 392 calls, median 0.00033, worst: 0.21 tolerances
    long steps: 333 calls, median 1.3e-08, worst: 0.024 tolerances
    higher order: 7 calls, median 0.061, worst: 0.48 tolerances
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from fractions import Fraction

import numpy as np

import polhode

PICKED = 8  # rows of a call that are judged


def body(dice: np.random.Generator) -> list[float] | None:
    """Moments of any body, a slender one or one that is nearly a ball; None where none has them."""
    moments = dice.uniform(0.2, 2, 3)
    kind = dice.integers(4)
    if kind == 0:
        moments = np.array([dice.uniform(0.01, 0.1), 1, 1 + dice.uniform(-0.005, 0.005)])
    elif kind == 1:
        moments = 1 + dice.uniform(-0.01, 0.01, 3)
    elif kind == 2:
        moments[1] = moments[0]
    moments = np.round(dice.permutation(moments), 6)
    return moments.tolist() if 2 * moments.max() < moments.sum() else None


def scene(dice: np.random.Generator) -> polhode.Scene | None:
    """A top of any speed, unit of time and weight."""
    moments = body(dice)
    if moments is None:
        return None
    unit = 2.0 ** (dice.integers(-20, 21) if dice.random() < 0.3 else 0)
    omega = dice.normal(size=3) * 10 ** dice.uniform(-2, 3) / unit
    if dice.random() < 0.2:
        omega[dice.integers(3)] = 1e-8 * np.abs(omega).max()  # near a separatrix, now and then
    return polhode.top(
        moments=moments,
        centre=np.round(dice.normal(size=3), 4).tolist(),
        weight=float(dice.choice([0, 0.1, 1, 10])) / unit**2,
        omega=omega.tolist(),
        gamma=dice.normal(size=3).tolist(),
        normalise=True,
        end=unit,
    )


def times(dice: np.random.Generator, end: float) -> np.ndarray:
    """Even or random ones, or dense near 0, of which some are asked for together."""
    count = int(dice.choice([1, 2, 3, 60, 101, 500, 3000]))
    parts = (
        np.linspace(0, 1, count + 1)[1:],
        np.sort(dice.random(count)),
        10 ** np.sort(dice.uniform(-9, 0, count)),
    )
    fractions = np.unique(parts[dice.integers(3)])
    return np.concatenate([[0.0][: dice.integers(2)], fractions]) * end


def main() -> None:
    """Run for some seconds."""
    seconds, seed = (float(x) for x in [*sys.argv[1:], "60", "0"][:2])
    dice, until = np.random.default_rng(int(seed)), time.monotonic() + seconds
    errors, rows = defaultdict(list), 0
    while time.monotonic() < until:
        top = scene(dice)
        if top is None:
            continue
        tol = 10 ** dice.uniform(-12, -1)
        go = polhode.propagator(top, tol=tol)
        rate, radians = float(np.sqrt(go._rate)), 10 ** dice.uniform(-2, 1.6)
        at = times(dice, float(dice.choice([1, -1])) * radians / rate)
        states = go(t=at)
        picked = np.unique([len(at) - 1, *dice.integers(0, len(at), PICKED)])
        picked = picked[at[picked] != 0]
        judged = top.at([Fraction(float(t)) for t in at[picked]])
        true = [[float(x) for x in row] for row in polhode.integrate(judged, "quad").states]
        off = np.abs(states[picked] - np.array(true))
        off[:, :3] /= rate
        long = any(steps._kept for steps in go._long_steps)
        route = (
            "long steps" if long else "higher order" if "_higher" in vars(go) else "heyoka's own"
        )
        errors[route].append((off.max() / tol, f"tol {tol:.0e}, {radians:.3g} radians, {len(at)}"))
        rows += len(picked)
    print(f"{rows} rows")
    for route, calls in errors.items():
        calls.sort(reverse=True)
        size = [error for error, _ in calls]
        print(f"{route}: {len(calls)} calls, median {np.median(size):.2g}, worst:")
        for error, words in calls[:3]:
            print(f"    {error:.2g} tolerances ({words} times)")


if __name__ == "__main__":
    main()
