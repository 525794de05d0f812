"""What tests of every room use: tiers, examples, policies, changed sources, answers of verbs.

Types of numbers and the exact value of a number come from here, so that a move is told once.
"""

import copy
import inspect
import json
import math
import signal
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import polhode
from polhode import NumberType
from polhode.common import values
from polhode.common.interrupts import ProgressLine
from polhode.numbers.expression import number as number
from polhode.scenes.library import names as library_names
from polhode.scenes.scene import even_times as even_times
from polhode.scenes.vocabulary import ANGLES as ANGLES
from polhode.scenes.vocabulary import ATTITUDE as ATTITUDE
from polhode.scenes.vocabulary import FORMS as FORMS
from polhode.scenes.vocabulary import STATE as STATE
from polhode.taylor import defaults

#: The names of the library's cases.
case_names = library_names

#: The checker of certificates, a file that runs alone.
CHECKER = Path(polhode.__file__).parent / "certificates" / "verify.py"

# -- number types, and exact values of numbers of any type, by code of the tests' own

DOUBLE, EXTENDED, QUAD = (
    NumberType(name, bits) for name, bits in (("double", 53), ("extended", 64), ("quad", 113))
)
EXTENDED_HERE = np.finfo(np.longdouble).nmant == 63


def mp(digits: float) -> NumberType:
    """The type of so many decimal digits."""
    return NumberType("mp", max(64, math.ceil(digits / math.log10(2)) + 1))


def exactly(x: Any) -> Fraction:
    """What a float, a long double, a number of mpmath's or any other rational one is."""
    raw = getattr(x, "_mpf_", None)
    if raw is None:
        return Fraction(*x.as_integer_ratio())
    sign, mantissa, exponent, _ = raw
    return (-1) ** sign * int(mantissa) * Fraction(2) ** int(exponent)


def exact_number(text: str) -> Any:
    """The exact number that a scene makes of a text: a Fraction, or an irrational one."""
    return polhode.top(moments=[1, 1, 1], omega=[0, 0, text]).omega[2]


def tiers(fast: Iterable[Any], slow: Iterable[Any]) -> list[Any]:
    """The fast cases, then the slow ones; the values of several parameters are a tuple."""
    return [*fast, *(slow_case(case) for case in slow)]


def slow_case(case: Any) -> Any:
    """A case with the mark of the slow tier."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)


def of_table(table: Iterable[Any], *fast: Any) -> list[Any]:
    """Every row of a table by its name; these are fast, the others slow."""
    return tiers(fast, [name for name in table if name not in fast])


# -- how many examples of a property are drawn where it says so itself

_CI = 100  # of which CI draws a half


def examples(count: int) -> int:
    """A half of so many in CI; elsewhere a quarter, as of those that say nothing."""
    return max(1, count * settings.default.max_examples // _CI)


# -- runs by another policy than that of the table


def change_policy(monkeypatch: pytest.MonkeyPatch, **changes: int) -> None:
    """Change columns of the policy table, for every number type and the rest of a test."""
    for name, row in defaults.TABLE.items():
        monkeypatch.setitem(defaults.TABLE, name, row._replace(**changes))


def change_memory(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """Let results have so many bytes at most, for the rest of a test."""
    monkeypatch.setattr(values, "MOST_BYTES", most)


def press_ctrl_c(monkeypatch: pytest.MonkeyPatch, count: int) -> list[str]:
    """Ctrl-C with the line of progress that is the ``count``-th; the lines, as they come."""
    lines: list[str] = []

    def say(_: Any, text: str) -> None:
        lines.append(text)
        if len(lines) == count:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(ProgressLine, "say", say)
    return lines


# -- a function with one piece of its text replaced, a certificate with one value replaced


@contextmanager
def without(module: Any, name: str, old: str, new: str) -> Iterator[None]:
    """``module.name``, or ``module.Class.name``, with ``old``, found there once, as ``new``."""
    owner, _, attribute = name.rpartition(".")
    home = getattr(module, owner) if owner else module
    honest = getattr(home, attribute)
    source = textwrap.dedent(inspect.getsource(honest))
    assert source.count(old) == 1, f"{name} no longer says {old!r} once"
    local: dict[str, Any] = {}
    exec(compile(source.replace(old, new), f"<{name}>", "exec"), module.__dict__, local)
    setattr(home, attribute, local[attribute])
    try:
        yield
    finally:
        setattr(home, attribute, honest)


def altered(certificate: Any, place: str, value: Any) -> Any:
    """A JSON value with another one at a place, or made of the one there.

    ``place``: keys and numbers, as ``statement start 0``.
    """
    changed = parent = copy.deepcopy(certificate)
    *path, last = (int(key) if key.isdigit() else key for key in place.split())
    for key in path:
        parent = parent[key]
    parent[last] = value(parent[last]) if callable(value) else value
    return changed


def leaves(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the numbers and words of a JSON value stand."""
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from leaves(value[key], (*at, key))
    else:
        yield at


def answer(certificate: Any) -> str:
    """What is proved of it; or "refused: " and why nothing is."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        path.write_text(json.dumps(certificate))
        try:
            verdict = polhode.verify(path)
        except polhode.BadInput as fault:
            return f"refused: {fault}"
    return verdict.text if verdict.proved else f"refused: {verdict.text}"


# -- a process of its own


def python(*words: str, **how: Any) -> subprocess.CompletedProcess[str]:
    """What Python does with such words."""
    how = {"capture_output": True, "text": True, "timeout": 300} | how
    return subprocess.run([sys.executable, *words], **how)


# -- what --json of a judgement says, by name

_PART = "correct_digits_"


def judged(text):
    """Facts and columns by name, and under ``parts`` the correct digits of each part."""
    judgement = json.loads(text)
    columns = judgement["columns"]
    parts = {k.removeprefix(_PART): x for k, x in columns.items() if k.startswith(_PART)}
    return judgement | columns | {"parts": parts}
