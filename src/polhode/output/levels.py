"""The levels of a body as a JSON object and as arrays; names and shapes are a contract."""

from __future__ import annotations

from polhode.common.json_text import JsonObject
from polhode.dynamics.levels.levels import Curve, Levels, Mark, topology
from polhode.dynamics.levels.regions import Region
from polhode.numbers.decimals import shown
from polhode.numbers.mpmath_context import mpf

DIGITS = 36


def of_levels(found: Levels) -> JsonObject:
    """The object that ``levels --json`` prints; numbers isolated exactly are decimal strings."""
    here = found.here
    return {
        "scene_name": found.scene.name,
        "exact": found.exact,
        "arcs": [_of_curve(curve) for curve in found.curves],
        "cusps": [_of_mark(mark) for mark in found.cusps],
        "hamiltonian_hopf": [_of_mark(m) for m in found.marks if m.kind == "Hamiltonian-Hopf"],
        "branches": [_of_mark(m) for m in found.marks if m.kind == "branch"],
        "scene": {
            "f": shown(here.f),
            "h": shown(here.h),
            "least_h": here.least,
            "region": of_region(here.region),
            "topology": topology(here.region),
            "remark": here.remark,
            "fourth": None
            if here.fourth is None
            else {
                "name": here.fourth.name,
                "value": here.fourth.value,
                "critical": [value._asdict() for value in here.fourth.critical],
            },
        },
        "provenance": dict(found.provenance),
    }


def arrays(found: Levels) -> JsonObject:
    """The arrays of an NPZ file: ``points`` (n, 2) of f and h, ``curve`` the curve of each."""
    import numpy as np

    from polhode.common import json_text

    counts = [len(curve.points) for curve in found.curves]
    return {
        "points": np.concatenate([curve.points for curve in found.curves]),
        "curve": np.repeat(np.arange(len(counts)), counts),
        "type": np.array([curve.type for curve in found.curves]),
        "about": np.array(json_text.as_json(of_levels(found))),
    }


def of_region(region: Region | None) -> list[int] | None:
    """The edges of each part; null on a bifurcation."""
    return None if region is None else list(region)


def _of_curve(curve: Curve) -> JsonObject:
    return {
        "family": curve.family,
        "axis": None if curve.axis is None else curve.axis + 1,
        "type": curve.type,
        "morse_index": curve.morse,
        "from": _number(curve.first),
        "to": _number(curve.last),
        "f": curve.points[:, 0].tolist(),
        "h": curve.points[:, 1].tolist(),
    }


def _of_mark(mark: Mark) -> JsonObject:
    parameter = "s" if mark.family == "first" else "om"
    found = {parameter: _number(mark.parameter), "f": _number(mark.f), "h": _number(mark.h)}
    return {"family": mark.family, **found}


def _number(x: mpf | None) -> str | None:
    if x is None:
        return None
    from polhode.numbers.conversion import exactly
    from polhode.numbers.decimals import decimal_string

    return decimal_string(exactly(x), DIGITS)
