"""The type of a JSON object as Python has it."""

from __future__ import annotations

from typing import Any, TypeAlias

#: Keys, and what JSON can hold: text, numbers, true, false, null, lists, objects.
JsonObject: TypeAlias = dict[str, Any]
