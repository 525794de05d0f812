"""Trajectories that some other program computed: a CSV with any subset of the columns beside t."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from polhode.equations.integrals import Drift, drift
from polhode.judging.conditioning import Conditioning, conditioning
from polhode.judging.digits import digits_of, errors, rate_scale
from polhode.judging.limits import is_lost, limit
from polhode.judging.lyapunov import Lyapunov, lyapunov
from polhode.judging.omega_alone import OmegaAlone, omega_alone
from polhode.judging.reference import Reference, TwoPrecisions
from polhode.judging.table import (
    Table,
)
from polhode.numbers.convert import to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, NumberType, mp
from polhode.scenes.scene import Scene
from polhode.scenes.words import ANGLES, ATTITUDE, SPACE, STATE

SPARE_DIGITS = 6


@dataclass(frozen=True)
class Verdict:
    """Correct digits of a table over time, and what could not be judged and why.

    ``yardstick``: the number type whose rounding the digits possible are about: the one named, else
    double, or one of as many digits as are printed where those are more than a double's 17.
    ``held``: the most correct digits that can be told.  ``omega_alone``: what omega says of gamma,
    where the file holds omega and not gamma.
    """

    table: Table
    reference: Reference | TwoPrecisions
    digits: tuple[float, ...]
    judged: tuple[str, ...]
    parts: dict[str, float]
    drift: Drift | None
    notes: tuple[str, ...]
    yardstick: NumberType
    held: float
    omega_alone: OmegaAlone | None = None

    @cached_property
    def conditionings(self) -> tuple[Conditioning, ...]:
        """Kappa at the table's times: from t = 0 ahead, and from t = 0 back."""
        scene, found = self.reference.scene, []
        for times in _by_sign(self.table.times):
            found.append(conditioning(scene, times, number=self.yardstick))
        return tuple(found)

    @cached_property
    def digits_possible(self) -> tuple[float | None, ...]:
        """The digits that kappa leaves in the yardstick's type, wherever digits were found."""
        if not self.digits:
            return ()
        known: dict[Exact, float | None] = {}
        for part in self.conditionings:
            known |= dict(zip(part.times, part.digits_possible(), strict=True))
        return tuple(known[t] for t in self.table.times)

    @property
    def lost_after(self) -> float | None:
        """The time after which kappa leaves the yardstick's type no digits; None where it does."""
        after = [part.lost_after for part in self.conditionings if part.lost_after is not None]
        return min(after, key=abs, default=None)

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        gone = any(map(is_lost, self.digits, self.digits_possible))
        return next((part.lost for part in self.conditionings if gone and part.lost), "")

    @cached_property
    def motion(self) -> Lyapunov:
        """Whether the scene's motion is regular or chaotic, as far as a moment's work tells."""
        return lyapunov(self.reference.scene, max_steps=100_000)

    @cached_property
    def limit(self) -> str | None:
        """What limits the digits: rounding, conditioning, method or reference; None unjudged."""
        if self.worst is None:
            return None
        if self.worst >= self.table.printed - 1:
            return "rounding (of the printed digits)"
        possible = self.digits_possible[self.digits.index(self.worst)]
        steps = "steps of the program" + "; kappa not computed" * (possible is None)
        held = min(self.held, self.yardstick.most_digits)
        return limit(self.worst, held, possible, self.reference.agreement, steps)

    @property
    def worst(self) -> float | None:
        """The fewest correct digits of the state; None where no column of it was there."""
        return min(self.digits, default=None)

    @property
    def worst_time(self) -> Fraction | None:
        """The first time at which the digits are fewest."""
        worst = self.worst
        return None if worst is None else self.table.times[self.digits.index(worst)]


def judge(table: Table, truth: Reference | TwoPrecisions, number: NumberType | None) -> Verdict:
    """Correct digits of a table against the reference of a scene."""
    scene = truth.scene
    cap = number.most_digits if number else float(min(table.printed + 2, 1000))
    wanted = math.ceil(cap) + SPARE_DIGITS
    bits = math.ceil(wanted * math.log2(10)) + 32
    notes = [f"column {name} is not known and was not judged" for name in table.ignored]
    notes += [f"column {name} was not judged: p q r are" for name in SPACE if name in table.columns]
    if not scene.columns[3:]:
        for name in (*STATE[3:], *ANGLES, *ATTITUDE):
            if name in table.columns:
                notes.append(f"column {name} was not judged: the scene has no gamma")
    judged = [name for name in scene.columns if name in table.columns]
    for name in scene.columns:
        if name not in judged:
            notes.append(f"column {name} is not in the file")
    digits: tuple[float, ...] = ()
    alone = None
    if judged:
        truth_rows = reference_rows(truth.at, table, wanted)
        states = [
            [table.columns[name][k] if name in judged else None for name in scene.columns]
            for k in range(len(table.times))
        ]
        scale = rate_scale(truth_rows, scene, bits)
        digits = tuple(digits_of(e, cap) for e in errors(states, truth_rows, scale, bits))
        if any(None in table.columns[name] for name in judged):
            notes.append("empty cells were not judged")
        if tuple(judged) == STATE[:3]:
            omega = [[to_mpf(x, bits) for x in row[:3] if x is not None] for row in states]
            if all(len(row) == 3 for row in omega):
                alone = omega_alone(scene, table.times, omega, truth_rows, bits)
    parts = _parts(table, truth, wanted, bits, cap, notes)
    found = _drift(table, scene, bits, notes)
    yardstick = number or (DOUBLE if table.printed <= DOUBLE.printed_digits else mp(table.printed))
    return Verdict(
        *(table, truth, digits, (*judged, *parts), parts, found, tuple(notes)),
        yardstick,
        cap,
        alone,
    )


def reference_rows(ask: Any, table: Table, digits: int) -> list[Any]:
    """Reference rows in the file's order: times of each sign are asked for away from 0."""
    rows: dict[Fraction, Any] = {}
    for times in _by_sign(table.times):
        rows |= dict(zip(times, ask(times, digits), strict=True))
    return [rows[t] for t in table.times]


def _by_sign(times: tuple[Fraction, ...]) -> list[list[Fraction]]:
    """The different times from 0 ahead, and those from 0 back, each in order; none empty."""
    ahead = sorted({t for t in times if t >= 0})
    behind = sorted({t for t in times if t < 0}, reverse=True)
    return [part for part in (ahead, behind) if part]


def _parts(
    table: Table,
    truth: Reference | TwoPrecisions,
    wanted: int,
    bits: int,
    cap: float,
    notes: list[str],
) -> dict[str, float]:
    """Digits of angles and attitude by absolute error; a quaternion may have the other sign."""
    parts: dict[str, float] = {}
    if len(truth.scene.columns) == 3:
        return parts
    for what, names, ask in (
        ("angles", ANGLES, truth.angles),
        ("attitude", ATTITUDE, truth.attitude),
    ):
        there = [name for name in names if name in table.columns]
        if not there:
            continue
        try:
            rows = reference_rows(ask, table, wanted)
        except ValueError as fault:  # BadInput is one
            notes.append(f"{what} were not judged: {fault}")
            continue
        own = [
            [table.columns[name][k] if name in there else None for name in names]
            for k in range(len(table.times))
        ]
        signs = (1, -1) if what == "attitude" else (1,)
        parts[what] = max(_part_digits(own, rows, s, bits, cap) for s in signs)
    return parts


def _part_digits(own: list[Any], rows: list[Any], s: int, bits: int, cap: float) -> float:
    import mpmath

    worst = cap
    with mpmath.workprec(bits):
        for mine, true in zip(own, rows, strict=True):
            for x, y in zip(mine, true, strict=True):
                if x is not None and y is not None:
                    worst = min(worst, digits_of(abs(s * to_mpf(x, bits) - y), cap))
    return worst


def _drift(table: Table, scene: Scene, bits: int, notes: list[str]) -> Drift | None:
    """Drift of the integrals, where the file has every column of the state."""
    columns = [table.columns.get(name) for name in scene.columns]
    if any(column is None or None in column for column in columns):
        notes.append("drift of the integrals was not judged: a column of the state is missing")
        return None
    if _was_projected(Path(table.name)):
        notes.append("drift of the integrals was not judged: they were projected")
        return None
    rows = [
        [to_mpf(x, bits) for x in row if x is not None]
        for row in zip(*(c for c in columns if c is not None), strict=True)
    ]
    return drift(scene, rows, bits)


def _was_projected(path: Path) -> bool:
    """Whether the JSON that polhode wrote beside a file says that its integrals were projected."""
    try:
        found = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    projection = found.get("projection") if isinstance(found, dict) else None
    if not isinstance(projection, dict):
        return False
    return bool(projection.get("count")) and "h" in projection.get("onto", ())
