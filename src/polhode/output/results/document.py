"""A result as a JSON document that gives back an equal one.

What pickle would hold, written as JSON, of polhode's own values alone: a document names no code
but the classes below and a few functions that make values, so that reading one runs nothing else.
A sum over the text finds a document that was changed or cut.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import sys
from enum import Enum
from fractions import Fraction
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np

from polhode.common.errors import BadInput, FileName
from polhode.common.result import Result
from polhode.output import archive
from polhode.runs.trajectory import Trajectory

#: Whatever a result holds, and what JSON makes of it.
Value: TypeAlias = Any

FORMAT = "polhode result 1"
#: Rooms whose classes a document may name, and the functions by which some values are made.
_ROOMS = ("dynamics", "enclosures", "judging", "motion", "numbers", "proofs", "runs", "scenes")
_MAKERS = {
    "polhode.judging.references.reference:reference",
    "polhode.numbers.exact:_irrational",
    "polhode.numbers.lossless_mpf:pair",
    "polhode.numbers.lossless_mpf:real",
}
_RULES = "polhode.numbers.ball_rules"  # all of them: of exact numbers that are not rational
#: Not part of a value: folders of unfinished work.
_LEFT_OUT = ("JobCheckpoint", "SweepCheckpoint")
_SAFE = 1 << 53  # integers that every reader of JSON keeps


def document(found: Result) -> dict[str, Value]:
    """The result's document."""
    value = _Writer().written(found)
    kind = type(found).__name__
    return {"format": FORMAT, "kind": kind, "sum": checksum(kind, value), "value": value}


def result_of(told: Value, name: str) -> Result:
    """The result of a document; raises BadInput."""
    expected = "a result that polhode saved"
    try:
        if told["format"] != FORMAT:
            raise ValueError(f"format {told['format']!r}")
        if told["sum"] != checksum(told["kind"], told["value"]):
            raise ValueError("it was changed or cut")
        found = _Reader().read(told["value"])
    except (KeyError, TypeError, ValueError, AttributeError, ImportError, RecursionError) as fault:
        if isinstance(fault, BadInput):
            raise
        raise BadInput(name, "file", None, f"{expected} ({fault})") from None
    if not isinstance(found, Result):
        raise BadInput(name, "file", None, expected)
    return found


def checksum(kind: str, value: Value) -> str:
    """What tells a document that was changed or cut."""
    text = json.dumps([kind, value], separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


class _Writer:
    """Writes values; one that occurs twice is written once and told by its number then."""

    def __init__(self) -> None:
        self.known: dict[int, int] = {}
        self.kept: list[object] = []  # so that no number of an object is used again

    def written(self, x: Value) -> Value:
        """The JSON value of x: plain where JSON has the type, else an object of one key."""
        if x is None or type(x) in (bool, str):
            return x
        if isinstance(x, FileName):  # where its user found it is no part of a result
            return str(x)
        if type(x) is int:
            return x if abs(x) < _SAFE else {"i": hex(x)}
        if type(x) is float:
            return x if math.isfinite(x) else {"f": repr(x)}
        if type(x) is complex:
            return {"c": [self.written(x.real), self.written(x.imag)]}
        if type(x) is list:
            return [self.written(item) for item in x]
        if type(x) is tuple:
            return {"t": [self.written(item) for item in x]}
        if type(x) is dict:
            return {"d": [[self.written(k), self.written(v)] for k, v in x.items()]}
        if type(x) is Fraction:
            return {"q": [hex(x.numerator), hex(x.denominator)]}
        if isinstance(x, np.ndarray):
            return {"a": [x.dtype.str, list(x.shape), self._elements(x)]}
        if isinstance(x, np.generic):
            return {"s": self.written(np.asarray(x))["a"]}
        if isinstance(x, Enum):
            return {"e": [_name_of(type(x)), self.written(x.value)]}
        if isinstance(x, type) or (callable(x) and hasattr(x, "__qualname__")):
            return {"g": _name_of(x)}
        return self._object(x)

    def _elements(self, x: Value) -> Value:
        if x.dtype.kind in "OUS":
            return [self.written(item) for item in x.ravel().tolist()]
        if x.dtype.itemsize > 8 and x.dtype.kind == "f":  # whose bytes differ between machines
            return [np.format_float_scientific(item, unique=True) for item in x.ravel()]
        return base64.b64encode(np.ascontiguousarray(x).tobytes()).decode()

    def _object(self, x: Value) -> Value:
        if type(x).__name__ in _LEFT_OUT:
            return None
        if id(x) in self.known:
            return {"r": self.known[id(x)]}
        if type(x) is Trajectory:
            told: Value = {"run": [[k, self.written(v)] for k, v in archive.arrays(x).items()]}
        else:
            reduced: Value = x.__reduce_ex__(2)
            make, args = reduced[0], list(reduced[1])
            state = reduced[2] if len(reduced) > 2 else None
            if make.__name__ == "__newobj__":
                told = {"n": [_name_of(args[0]), *map(self.written, args[1:])]}
            else:
                told = {"o": [_name_of(make), *map(self.written, args)]}
            if state is not None:
                told["w"] = self.written(state)
        self.known[id(x)] = len(self.kept)
        self.kept.append(x)
        return told


class _Reader:
    """Reads what a writer wrote."""

    def __init__(self) -> None:
        self.kept: list[object] = []

    def read(self, told: Value) -> Value:
        """The value; raises what a damaged document makes fail."""
        if isinstance(told, list):
            return [self.read(item) for item in told]
        if not isinstance(told, dict):
            return told
        key, value = next(iter(told.items()))
        if key in ("n", "o", "run"):
            return self._object(key, value, told)
        return getattr(self, f"_{key}")(value)

    def _object(self, key: str, value: Value, told: Value) -> Value:
        if key == "run":
            found: Value = archive.run_of({k: self.read(v) for k, v in value})
        else:
            make = _named(value[0])
            args = [self.read(item) for item in value[1:]]
            found = make.__new__(make, *args) if key == "n" else make(*args)
            if "w" in told:
                _stated(found, self.read(told["w"]))
        self.kept.append(found)
        return found

    def _i(self, value: str) -> int:
        return int(value, 16)

    def _f(self, value: str) -> float:
        return float(value)

    def _c(self, value: Value) -> complex:
        return complex(self.read(value[0]), self.read(value[1]))

    def _t(self, value: Value) -> tuple[Value, ...]:
        return tuple(self.read(item) for item in value)

    def _d(self, value: Value) -> dict[Value, Value]:
        return {self.read(k): self.read(v) for k, v in value}

    def _q(self, value: Value) -> Fraction:
        return Fraction(int(value[0], 16), int(value[1], 16))

    def _a(self, value: Value) -> Value:
        dtype, shape, elements = np.dtype(value[0]), tuple(value[1]), value[2]
        if isinstance(elements, str):
            flat: Value = np.frombuffer(base64.b64decode(elements), dtype=dtype).copy()
        elif dtype.kind == "f":
            flat = np.array([np.longdouble(text) for text in elements], dtype=np.longdouble)
        else:
            flat = np.empty(len(elements), dtype=dtype)
            for k, item in enumerate(elements):
                flat[k] = self.read(item)
        return flat.reshape(shape)

    def _s(self, value: Value) -> Value:
        return self._a(value)[()]

    def _e(self, value: Value) -> Value:
        return _named(value[0])(self.read(value[1]))

    def _g(self, value: str) -> Value:
        return _named(value)

    def _r(self, value: int) -> Value:
        return self.kept[value]


def _name_of(x: Value) -> str:
    """Where a class or a function stands; refuses what a document may not name."""
    name = f"{x.__module__}:{x.__qualname__}"
    if _named(name) is not x:
        raise TypeError(f"{name}: no part of a result")
    return name


def _named(name: str) -> Value:
    module, _, own = name.partition(":")
    package, _, rest = module.partition(".")
    allowed = package == "polhode" and rest.partition(".")[0] in _ROOMS and "." not in own
    found = getattr(sys.modules.get(module) or import_module(module), own) if allowed else None
    if isinstance(found, type) and found.__module__ == module:
        return found
    if found is None or (name not in _MAKERS and module != _RULES):
        raise ValueError(f"{name}: no part of a result")
    return found


def _stated(found: Value, state: Value) -> None:
    """Give an object its fields, as unpickling does."""
    if hasattr(found, "__setstate__"):
        found.__setstate__(state)
        return
    slots: Value = None
    if isinstance(state, tuple) and len(state) == 2:
        state, slots = state
    for fields in (state, slots):
        for key, value in (fields or {}).items():
            object.__setattr__(found, key, value)
