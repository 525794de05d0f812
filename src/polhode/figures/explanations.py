"""What a motion looks like, in two sentences, by the kind of its reference and its regime."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign
from polhode.scenes.body import CHAPLYGIN, Body, kind_of_body
from polhode.scenes.scene import Scene


class Explanation(NamedTuple):
    """Of regimes of one kind of reference that begin with these words: what is seen."""

    kind: str
    begins: str
    text: str


def _flat(text: str) -> str:
    return " ".join(text.split())


_FILE = Path(__file__).parent / "page" / "explanations.toml"
_TOLD = tomllib.loads(_FILE.read_text(encoding="utf-8"))
_PARTS = {name: _flat(text) for name, text in _TOLD["parts"].items()}
_OTHERS = {name: _flat(text) for name, text in _TOLD["others"].items()}
#: The first that fits is shown.
EXPLANATIONS = tuple(
    Explanation(x["kind"], x["begins"], _flat(x["text"]).format_map(_PARTS))
    for x in _TOLD["explanations"]
)
_CLOSE = 0.01


def explained(kind: str, regime: str, scene: Scene) -> str:
    """Two sentences on a motion; ``kind`` and ``regime`` of its reference."""
    body = scene.body
    if kind == "euler" and regime.startswith("polhode") and _turns_over(scene):
        return _OTHERS["tennis"]
    upward = not body.torque_free and sign(body.weight) < 0
    return _words(kind, regime, body) + (f" {_OTHERS['upward']}" if upward else "")


def _turns_over(scene: Scene) -> bool:
    """Whether the polhode is close to the separatrices: 2 T B near G², A < B < C."""
    small, middle, large = sorted(to_double(x) for x in scene.body.moments)
    w = [to_double(x) for x in scene.omega]
    momentum = [to_double(x) for x in scene.body.momentum(scene.omega)]
    square = sum(x * x for x in momentum)
    off = middle * sum(x * y for x, y in zip(w, momentum, strict=True)) - square
    return abs(off) < _CLOSE * square * (large - small) / middle


def _words(kind: str, regime: str, body: Body) -> str:
    if regime.startswith("rest"):
        return _OTHERS["rest"]
    for kinds, begins, text in EXPLANATIONS:
        if kind == kinds and regime.startswith(begins):
            return text
    if kind == "certified":
        return _OTHERS["chaplygin" if kind_of_body(body) == CHAPLYGIN else "none"]
    return f"A motion with a closed form ({kind}): {regime}."
