"""Thousands of hostile inputs of each class: is the promise of :mod:`fuzz.promise` kept?

    python tests/campaigns/hostile_input.py [SHARE] [CLASS...]

tries SHARE (1 if it is not said) of the counts below, of the classes that are named or of all, and
then as many extreme scenes of each kind; it prints how the cases of a class ended, and every fault
with the input that makes it.  The exit code is 1 where there was one.

Last printed, with SHARE 0.004 of six classes; a whole run takes hours and has not been made since:

    scene: ended with {0, 2}
    toml: ended with {2}
    table: ended with {0, 2}
    command: ended with {2}
    body: ended with {False, True}
    event: ended with {False}
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz import cases, trials
from polhode.output import description

COUNTS = {
    **dict.fromkeys(("scene", "call", "any result"), 6000),
    **dict.fromkeys(("toml", "command", "body"), 2000),
    "table": 1000,
    "event": 500,
    "proof": 50,
}
EXTREME = 100  # scenes of each kind


def jobs(share: float) -> Iterator[tuple[str, Callable[[], Any]]]:
    """What is tried, by name."""
    for name, count in COUNTS.items():
        most = max(1, round(share * count))
        yield name, lambda name=name, most=most: trials.keep_many(name, most)
    for name in cases.KINDS:
        most = max(1, round(share * EXTREME))
        yield (
            f"extreme {name}",
            lambda name=name, most=most: trials.judge_extreme_scenes(name, most),
        )


def main(share: str = "1", *names: str) -> int:
    """Try them, each class in a folder of its own."""
    description.SECONDS = 0.05  # that show looks for frequencies
    faults = 0
    for name, job in jobs(float(share)):
        if names and name not in names:
            continue
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            cases.prepared(Path(folder))
            try:
                print(f"{name}: ended with {job() or 'no fault'}", flush=True)
            except Exception:  # several faults of a class come as a group
                faults += 1
                print(f"{name}: FAULT\n{traceback.format_exc()}", flush=True)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
