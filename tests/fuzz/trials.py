"""So many cases of each class, as hypothesis makes them, and whether the promise is kept.

A class of cases is a strategy; see :mod:`fuzz.promise` for what is promised.
"""

import contextlib
import io
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings

import polhode
from fuzz import cases, promise
from polhode.numbers.mpmath_context import mpf, mpmath, own
from shared import plain_taylor
from shared.closed_forms import number
from shared.results import MAKERS

#: Kinds of results that take little to make, a run in quad among them.
QUICK_RESULTS = (
    *("Trajectory in quad", "Ensemble", "Judgement", "Enclosure", "Reductions", "Lyapunov"),
)

CLASSES = {
    "scene": cases.scene(),
    "call": cases.call(),
    "toml": cases.toml(),
    "table": cases.table(),
    "command": cases.command(),
    "result": cases.result(QUICK_RESULTS),
    "any result": cases.result([*MAKERS]),
    "body": cases.body(),
    "event": cases.event(),
    "proof": cases.proof(),
}
OPTIONS: dict[str, Any] = {"database": None, "deadline": None}
OPTIONS |= {"suppress_health_check": [*HealthCheck]}
DIGITS = 25


def keep(case: cases.Case) -> int | bool | None:
    """Its exit code, or whether it was refused; the promise is kept."""
    cases.prepared(Path())
    for name, text in case.files.items():
        Path(name).write_bytes(text)
    if isinstance(case.work, list):
        faults, end = promise.of_command(case.work)
    else:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            faults, end = promise.of_call(case.work)
    assert not faults, "\n".join(faults)
    return end


def keep_many(kind: str, count: int) -> set[int | bool | None]:
    """So many cases of a class, in the current folder, and how they ended."""
    ends = set()

    @settings(max_examples=count, **OPTIONS)
    @given(CLASSES[kind])
    def keep_each(case: cases.Case) -> None:
        ends.add(keep(case))

    keep_each()
    return ends


# -- extreme and yet valid scenes, beside power series that share nothing with the package ---------


def departure(rows: Sequence[Any], true: Sequence[Any], rate: Fraction) -> mpf:
    """The largest error of omega over the spin, or of gamma."""
    pairs = [
        (own(x) / (number(rate) if k < 3 else 1), number(y))
        for row, right in zip(rows, true, strict=True)
        for k, (x, y) in enumerate(zip(row, right, strict=True))
    ]
    return max(abs(x - y) for x, y in pairs)


def true_rows(scene: polhode.Scene, rate: Fraction) -> list[list[Fraction]]:
    """The motion by power series, in a unit of time in which the spin is about 1."""
    largest = max(scene.body.moments)
    moments = [m / largest for m in scene.body.moments]
    torque = [x / largest / rate**2 for x in scene.body.torque]
    omega, times = [w / rate for w in scene.omega], [t * rate for t in scene.times]
    digits = DIGITS + 40  # differences of moments are as small as 1e-30
    return plain_taylor.integrate(moments, torque, omega, scene.gamma, times, digits)


def judge_extreme_scenes(kind: str, count: int) -> None:
    """Right to every digit asked, and a run to as many as is said."""

    @settings(max_examples=count, **OPTIONS)
    @given(cases.extreme(kind))
    def as_right_as_said(drawn: polhode.Scene) -> None:
        run = polhode.integrate(drawn)
        assert run.outcome.done
        scene = run.scene.at(run.times)  # those that the run was made for: rounded ones
        rate = max(abs(w) for w in scene.omega)
        true, reference = true_rows(scene, rate), polhode.reference(scene)
        worst = polhode.compare(run).worst
        with mpmath.workdps(DIGITS + 15):
            if kind != "general":
                assert reference.is_closed_form
                exact = reference.at(scene.times, DIGITS)
                assert departure(exact, true, rate) < mpf(10) ** (1 - DIGITS)
            error = departure([[mpf(float(x)) for x in row] for row in run.states], true, rate)
            fastest = max(mpmath.norm([number(x) for x in row[:3]]) for row in true)
            assert error < max(1.01 * mpf(10) ** -worst * max(1, fastest), mpf(2) ** -50)
        assert worst > 12

    as_right_as_said()
