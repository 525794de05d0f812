"""A chaos map as a JSON object and as arrays; names and shapes are a contract."""

from __future__ import annotations

from polhode.common.json_text import JsonObject
from polhode.dynamics.chaos.chaos_map import ChaosMap
from polhode.numbers.decimals import shown

_ROWS = ("at", "cell", "verdict", "fli", "megno", "growth", "exponent", "until")


def of_map(found: ChaosMap) -> JsonObject:
    """The object that ``map --json`` prints: lists with an entry a motion."""
    rows = {name: getattr(found, name).tolist() for name in _ROWS}
    rows["verdict"] = [found.words[k] for k in rows["verdict"]]
    return {**_about(found), **rows, "provenance": dict(found.provenance)}


def arrays(found: ChaosMap) -> JsonObject:
    """The arrays of an NPZ file; ``verdict`` 0 regular, 1 undecided, 2 chaotic or unstable."""
    import numpy as np

    from polhode.common import json_text

    about = json_text.as_json(_about(found) | {"provenance": dict(found.provenance)})
    return {name: getattr(found, name) for name in _ROWS} | {"about": np.array(about)}


def means(found: ChaosMap) -> str:
    """What the verdicts rest on: how far the motions were followed, and whether that is enough."""
    if not found.too_short:
        return f"regular means up to t = {found.end:g}"
    return (
        f"{found.counts['undecided']} undecided: t = {found.end:g} is too short, none is called "
        f"regular before t = {found.enough:g}; an end of {found.enough:g} or more can decide"
    )


def _about(found: ChaosMap) -> JsonObject:
    return {
        "scene": found.scene.name,
        "h": None if found.h is None else shown(found.h),
        "f": None if found.f is None else shown(found.f),
        "end": found.end,
        "keys": list(found.keys),
        "shape": list(found.shape),
        "least_end": found.enough,
        "counts": found.counts,
        "notes": [means(found)] if found.too_short else [],
        "interrupted": found.interrupted,
    }
