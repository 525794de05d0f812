"""A result as a JSON document that gives back an equal one.

A document holds values of polhode alone: numbers, texts, arrays, lists, and objects of the classes
in :mod:`polhode.output.results.kinds`, field by field, each of the field's type.  It names no code.
A sum over the text finds a document that was changed or cut.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np
from mpmath import libmp

from polhode.common.errors import BadInput, FileName
from polhode.judging.references.reference import Reference, reference
from polhode.motion.outcomes import Outcome
from polhode.numbers import ball_rules
from polhode.numbers.exact import Irrational
from polhode.numbers.lossless_mpf import real
from polhode.output import archive
from polhode.output.results import kinds
from polhode.output.results.kinds import Value
from polhode.results.result import Result
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene

FORMAT = "polhode document 2"
MOST_BITS = 1 << 18  # of an integer, and of the exponent of a number
MOST_BYTES = 1 << 31  # of an array
_SAFE = 1 << 53  # integers that every reader of JSON keeps
#: How an irrational number is made of others: names of functions on balls.
_RULES = {
    name: rule
    for name, rule in vars(ball_rules).items()
    if getattr(rule, "__module__", "") == ball_rules.__name__ and not name.startswith("_")
}


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
            raise ValueError(f"format {str(told['format'])[:40]!r}")
        if told["sum"] != checksum(told["kind"], told["value"]):
            raise ValueError("it was changed or cut")
        found = _Reader().read(told["value"])
    except archive.DAMAGED as fault:
        raise BadInput(name, "file", None, f"{expected} ({_line(fault)})") from None
    if not isinstance(found, Result) or type(found).__name__ != told["kind"]:
        raise BadInput(name, "file", None, expected)
    return found


def _line(fault: BaseException) -> str:
    return "it is damaged" if isinstance(fault, (KeyError, RecursionError)) else str(fault)


def checksum(kind: str, value: Value) -> str:
    """What tells a document that was changed or cut."""
    text = json.dumps([kind, value], separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


class _Writer:
    """Writes values; an object that occurs twice is written once and told by its number then."""

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
        if hasattr(x, "_mpf_"):
            sign, mantissa, exponent, _ = x._mpf_
            if not mantissa and exponent:
                return {"m": str(float(x))}
            return {"m": [hex(-int(mantissa) if sign else int(mantissa)), int(exponent)]}
        if isinstance(x, np.ndarray):
            return {"a": [x.dtype.str, list(x.shape), self._elements(x)]}
        if isinstance(x, np.generic):
            return {"s": self.written(np.asarray(x))["a"]}
        if isinstance(x, Outcome):
            return {"e": x.value}
        return self._object(x)

    def _elements(self, x: Value) -> Value:
        if x.dtype.kind in "OU":
            return [self.written(item) for item in x.ravel().tolist()]
        if x.dtype.itemsize > 8 and x.dtype.kind == "f":  # whose bytes differ between machines
            return [np.format_float_scientific(item, unique=True) for item in x.ravel()]
        return base64.b64encode(np.ascontiguousarray(x).tobytes()).decode()

    def _object(self, x: Value) -> Value:
        if id(x) in self.known:
            return {"r": self.known[id(x)]}
        if type(x) is Trajectory:
            told: Value = {"run": [[k, self.written(v)] for k, v in archive.arrays(x).items()]}
        elif isinstance(x, Irrational):
            told = {"x": [x._rule.__name__, self.written(list(x._parts)), self.written(x.square)]}
        elif isinstance(x, Reference):
            told = {"reference": self.written(x.scene)}
        else:
            word = kinds.word_of(x)
            told = {"n": [word, *(self.written(getattr(x, k)) for k in kinds.fields_of(word))]}
        self.known[id(x)] = len(self.kept)
        self.kept.append(x)
        return told


class _Reader:
    """Reads what a writer wrote; raises ValueError and the like for anything else."""

    def __init__(self) -> None:
        self.kept: list[object] = []
        self.readers: dict[str, Callable[[Value], Value]] = {
            "a": self._array,
            "c": lambda value: complex(*self._floats(value)),
            "d": lambda value: {self.read(k): self.read(x) for k, x in value},
            "e": Outcome,
            "f": _infinite,
            "i": _integer,
            "m": _mpf,
            "n": lambda value: self._keep(kinds.made(value[0], self._list(value[1:]))),
            "q": _fraction,
            "r": self._again,
            "reference": lambda value: self._keep(_reference(self.read(value))),
            "run": lambda value: self._keep(archive.run_of({k: self.read(x) for k, x in value})),
            "s": lambda value: self._array(value)[()],
            "t": lambda value: tuple(self._list(value)),
            "x": lambda value: self._keep(self._irrational(*value)),
        }

    def read(self, told: Value) -> Value:
        """The value."""
        if isinstance(told, list):
            return self._list(told)
        if not isinstance(told, dict):
            return told
        if len(told) != 1:
            raise ValueError("an object of several keys")
        ((key, value),) = told.items()
        return self.readers[key](value)

    def _list(self, told: Value) -> list[Value]:
        if not isinstance(told, list):
            raise ValueError("no list")
        return [self.read(item) for item in told]

    def _keep(self, found: Value) -> Value:
        self.kept.append(found)
        return found

    def _again(self, value: Value) -> Value:
        if type(value) is not int or not 0 <= value < len(self.kept):
            raise ValueError("an object that is not there")
        return self.kept[value]

    def _floats(self, told: Value) -> list[float]:
        found = self._list(told)
        if not all(type(x) is float for x in found):
            raise ValueError("no floats")
        return found

    def _array(self, value: Value) -> Value:
        word, shape, elements = value
        dtype, count = np.dtype(str(word)), math.prod(shape)
        if dtype.kind not in "biufcOU" or not all(type(n) is int and n >= 0 for n in shape):
            raise ValueError(f"an array of {str(word)[:20]}")
        if isinstance(elements, str):
            if dtype.kind in "OU":
                raise ValueError("no elements")
            flat: Value = np.frombuffer(base64.b64decode(elements, validate=True), dtype).copy()
        elif dtype.kind == "f":
            flat = np.array([np.longdouble(text) for text in elements], dtype=np.longdouble)
        elif dtype.kind == "U":
            longest = max((len(_text(x)) for x in elements), default=0)
            if 4 * longest * len(elements) > MOST_BYTES:
                raise ValueError("texts of too many bytes")
            flat = np.array(elements, dtype=np.str_)
        elif dtype.kind == "O":
            flat = np.empty(len(elements), dtype=object)
            for k, item in enumerate(elements):
                flat[k] = self.read(item)
                if isinstance(flat[k], (str, list, tuple, dict)):
                    raise ValueError("an array of other things than numbers")
        else:
            raise ValueError("no elements")
        if len(flat) != count:
            raise ValueError(f"an array of {len(flat)} elements")
        return flat.reshape(shape)

    def _irrational(self, word: str, parts: Value, square: Value) -> Irrational:
        rule, numbers, known = _RULES[word], self._list(parts), self.read(square)
        if rule.__code__.co_argcount != len(numbers) or not all(
            isinstance(x, (Fraction, Irrational)) for x in [*numbers, known or Fraction(0)]
        ):
            raise ValueError("no irrational number")
        return Irrational(rule, *numbers, square=known)


def _text(x: Value) -> str:
    if not isinstance(x, str):
        raise ValueError("no text")
    return x


def _integer(text: Value) -> int:
    if not isinstance(text, str) or len(text) > MOST_BITS // 4:
        raise ValueError("an integer that is too long")
    return int(text, 16)


def _fraction(told: Sequence[Value]) -> Fraction:
    above, below = map(_integer, told)
    return Fraction(above, below)


def _infinite(text: Value) -> float:
    return {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}[text]


def _mpf(told: Value) -> Value:
    if isinstance(told, str):
        return real(libmp.from_float(_infinite(told)))
    mantissa, exponent = told
    if type(exponent) is not int or abs(exponent) > MOST_BITS:
        raise ValueError("an exponent that is too large")
    return real(libmp.from_man_exp(_integer(mantissa), exponent))


def _reference(scene: Value) -> Value:
    if not isinstance(scene, Scene):
        raise ValueError("no scene")
    return reference(scene)
