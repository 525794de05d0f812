"""JSON for people and programs: objects as Python has them, and their text."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

#: Keys, and what JSON can hold: text, numbers, true, false, null, lists, objects.
JsonObject: TypeAlias = dict[str, Any]


def as_json(value: object) -> str:
    """JSON text, ASCII: a line for each key of an object and for each row of a table."""
    from json import dumps

    return _json(value, 0, partial(dumps, ensure_ascii=True, allow_nan=False)) + "\n"


def _json(value: object, depth: int, dumps: Callable[[object], str]) -> str:
    inner, outer = "\n" + " " * (depth + 1), "\n" + " " * depth
    if isinstance(value, dict) and value:
        lines = [f"{dumps(str(k))}: {_json(v, depth + 1, dumps)}" for k, v in value.items()]
        return "{" + inner + ("," + inner).join(lines) + outer + "}"
    if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
        lines = [_json(v, depth + 1, dumps) for v in value]
        return "[" + inner + ("," + inner).join(lines) + outer + "]"
    return dumps(value)
