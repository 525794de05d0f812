"""Study ``dynamics``: levels of six bodies, sections beside exact curves, a map, what it costs."""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.dynamics.chaos.chaos_map import chaos_map
from polhode.dynamics.levels.levels import levels, topology
from polhode.dynamics.sections import coordinates as geometry
from polhode.dynamics.sections.jobs import level_of
from polhode.dynamics.sections.section import Section, section
from polhode.numbers.conversion import to_double
from polhode.scenes import library
from polhode.scenes.scene_file import parse
from polhode.studies.dynamics import cost
from polhode.studies.row_filter import Only

NAME = "dynamics"
QUESTION = (
    "Which motions does a level of energy and area hold, where do its orbits cross a section and "
    "how exactly, where does chaos begin beside an integrable body, and what does it cost?"
)
EPS = 2.0**-52
COLUMNS, POINTS = 61, 60  # of a body's regions along f; of each curve, at most
FINE = (72, 60)  # cells on which the exact curves are drawn
SHOWN = 80  # crossings of an orbit in the figure
LONG = 300  # crossings of an orbit


class LevelsOf(NamedTuple):
    """A body by a case that has it, and its name."""

    case: str
    what: str


class SectionOf(NamedTuple):
    """A level of an integrable top; ``h``, ``f`` None: the case's own."""

    case: str
    what: str
    integral: str
    h: Fraction | None = None
    f: Fraction | None = None


BODIES = (
    LevelsOf("euler/attitude", "Euler"),
    LevelsOf("lagrange/nutation", "Lagrange"),
    LevelsOf("kovalevskaya/generic", "Kovalevskaya"),
    LevelsOf("goryachev-chaplygin/two-frequencies", "Goryachev–Chaplygin"),
    LevelsOf("hess/loxodrome", "Hess"),
    LevelsOf("general/asymmetric-chaotic", "asymmetric"),
)
TOPS = (
    SectionOf("euler/attitude", "Euler", "|G|²", Fraction(3), Fraction(6, 5)),
    SectionOf("lagrange/nutation", "Lagrange", "spin"),
    SectionOf("kovalevskaya/generic", "Kovalevskaya", "K²"),
    SectionOf("goryachev-chaplygin/two-frequencies", "Goryachev–Chaplygin", "F"),
)
#: A = B = 2, the centre across: C = 1/2, 1 and 2 are integrable; f = 0 for every C and spin.  On
#: no such body is the start on a separatrix, where neighbours part exponentially, too.
ACROSS = """schema = 1
title = "A symmetric body whose third moment varies"
[body]
moments = [2, 2, 1]
centre = [1, 0, 0]
weight = 1
[start]
omega = ["4/5", "-3/5", 1]
gamma = ["3/5", "4/5", 0]
"""
THIRD, SPIN = "body.moments[3]", "start.omega[3]"
INTEGRABLE = {"1/2": "Goryachev–Chaplygin", "1": "Kovalevskaya", "2": "a sphere (Lagrange)"}
CELLS, END = (61, 31), 1000


def rows(
    quick: bool = False,
    tick: Callable[[str], None] | None = None,
    only: Only | None = None,
) -> dict[str, Any]:
    """The study's results as a JSON object."""
    wanted = only or Only()

    def told(text: str) -> None:
        if tick is not None:
            tick(f"{NAME}: {text}")

    diagrams, cuts, maps, costs = [], [], [], []
    for body in BODIES[2:3] if quick else BODIES:
        if wanted(f"levels {body.what}", body.case):
            told(f"levels, {body.what}")
            diagrams.append(_levels(body))
    for top in TOPS[1:3] if quick else TOPS:
        if wanted(f"section {top.what}", top.case):
            told(f"section, {top.what}")
            cuts.append(_section(top, (2, 2) if quick else (5, 4)))
    if wanted("map across three integrable bodies"):
        told("map")
        maps.append(_map((7, 3) if quick else CELLS))
    for row in cost.rows(quick, wanted, told):
        costs.append(row)
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "levels": diagrams,
        "sections": cuts,
        "maps": maps,
        "cost": costs,
    }


def versions() -> dict[str, str]:
    """Those of the other programs."""
    return cost.versions()


def _levels(body: LevelsOf) -> dict[str, Any]:
    from polhode.figures.levels import window

    began = time.process_time()
    found = levels(library.load(body.case))
    seconds = time.process_time() - began
    shown = window(found)
    span = (shown.f[1] - shown.f[0]) / 1e6  # f = 0 itself may be critical everywhere
    ends = [x or (span if x == shown.f[0] else -span) for x in shown.f]
    here = found.here
    return {
        "case": body.case,
        "what": body.what,
        "arcs": len(found.curves),
        "stable": sum(curve.morse == 0 for curve in found.curves),
        "cusps": len(found.cusps),
        "hopf": sum(mark.kind == "Hamiltonian-Hopf" for mark in found.marks),
        "branches": sum(mark.kind == "branch" for mark in found.marks),
        "f": to_double(here.f),
        "h": to_double(here.h),
        "topology": topology(here.region),
        "fourth": None if here.fourth is None else here.fourth.name,
        "critical": [] if here.fourth is None else [v.value for v in here.fourth.critical],
        "seconds": round(seconds, 3),
        "window": [[*shown.f], [*shown.h]],
        "columns": [
            [_short(c.f), [_short(e) for e in c.energies], [[*region] for region in c.regions]]
            for c in found.columns(ends[0], ends[1], COLUMNS)
        ],
        "curves": [
            [curve.type, curve.morse, _thinned(curve.points, shown)] for curve in found.curves
        ],
        "marks": [
            [mark.kind, _short(float(mark.f)), _short(float(mark.h))] for mark in found.marks
        ],
    }


def _thinned(points: Any, shown: Any) -> list[list[float]]:
    """Some points of a curve that are in the window or next to it."""
    (f0, f1), (h0, h1) = shown
    wide, tall = f1 - f0, h1 - h0
    inside = (np.abs(points[:, 0] - (f0 + f1) / 2) < wide) & (points[:, 1] < h1 + tall)
    kept = points[inside]
    step = max(1, -(-len(kept) // POINTS))
    kept = np.concatenate([kept[:-1:step], kept[-1:]]) if len(kept) else kept
    return [[_short(x) for x in point] for point in kept]


def _section(top: SectionOf, grid: tuple[int, int]) -> dict[str, Any]:
    """Crossings of orbits, their integral's spread, and the integral over the whole section."""
    scene = library.load(top.case)
    found = section(scene, grid=grid, crossings=LONG, h=top.h, f=top.f)
    on = geometry.ground(scene, found.h, found.f)
    values = _fourth(found, _principal(found, on))
    scale = float(np.abs(values).max())
    spread = values.max(axis=1) - values.min(axis=1)
    l, sig = geometry.cells(*FINE)
    states = geometry.momentum_states(on, l, sig, True)
    field = np.full(len(l), np.nan)
    field[states.of[::-1]] = _fourth(found, states.states[::-1]).astype(float)
    shown = slice(0, SHOWN)
    return {
        "case": top.case,
        "what": top.what,
        "integral": top.integral,
        "h": to_double(found.h),
        "f": to_double(found.f),
        "orbits": len(found.counts),
        "crossings": int(found.counts.min()),
        "end": round(float(np.nanmax(found.times)), 1),
        "spread": float(spread.max()),
        "spread_in_eps": round(float(spread.max()) / (scale * EPS), 2),
        "scale": scale,
        "digits": [
            round(float(x), 1) for x in (found.digits.min(), np.median(found.digits[:, -1]))
        ],
        "values": [_short(float(v[0])) for v in values],
        "l": [[round(float(x), 4) for x in row[shown]] for row in found.l],
        "ratio": [[round(float(x), 4) for x in row[shown]] for row in found.ratio],
        "cells": [*FINE],
        "field": [None if np.isnan(x) else _short(float(x)) for x in field],
    }


def _principal(found: Section, on: geometry.Ground) -> Any:
    """The states of all crossings in principal axes."""
    rows = np.array([[to_double(x) for x in row] for row in found.scene.body.axes.rows])
    unit = 2.0**found.scene.time_unit
    states = found.states
    return np.concatenate([states[..., :3] @ rows.T * unit, states[..., 3:] @ rows.T], axis=-1)


def _fourth(found: Section, states: Any) -> Any:
    """The fourth integral at states (..., 6), in longdoubles."""
    known = level_of(found.scene, found.h, found.f)
    wide = [x.astype(np.longdouble) for x in np.moveaxis(states, -1, 0)]
    return known.integrals.values(wide, known.coefficients, 0 * wide[0])[-1]


def _map(cells: tuple[int, int]) -> dict[str, Any]:
    scene = parse(ACROSS, "across")
    varied = {THIRD: f"1/2:2:{cells[0]}", SPIN: f"1/10:3:{cells[1]}"}
    began = time.process_time()
    found = chaos_map(scene, varied=varied, end=END)
    third = found.at[:, 0]
    columns = []
    for text, what in INTEGRABLE.items():
        here = third == to_double(Fraction(text))
        counts = [int((found.verdict[here] == k).sum()) for k in range(3)]
        columns.append({"C": text, "what": what, "motions": int(here.sum()), "counts": counts})
    return {
        "keys": [*found.keys],
        "shape": [*found.shape],
        "end": found.end,
        "seconds": round(time.process_time() - began, 2),
        "counts": {name: found.counts[name] for name in found.words},
        "columns": columns,
        "x": [round(float(x), 5) for x in np.unique(third)],
        "y": [round(float(x), 5) for x in np.unique(found.at[:, 1])],
        "verdict": [int(x) for x in found.verdict[np.argsort(found.cell)]],
    }


def _short(x: float) -> float:
    """Five figures: what a drawing needs."""
    return float(f"{x:.5g}")
