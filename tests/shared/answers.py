"""What ``--json`` of a judgement says, by name."""

from __future__ import annotations

import json

_PART = "correct_digits_"


def judged(text):
    """Facts and columns by name, and under ``parts`` the correct digits of each part."""
    judgement = json.loads(text)
    columns = judgement["columns"]
    parts = {k.removeprefix(_PART): x for k, x in columns.items() if k.startswith(_PART)}
    return judgement | columns | {"parts": parts}
