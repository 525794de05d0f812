"""What each test costs: seconds of processor time, its fixtures and child processes included.

    python tests/measure/costs.py TIMES.json [PYTEST ARGUMENTS...]

Wall clock says little where other work shares the machine; processor time says more.  Arguments
of pytest choose the tests, the fast ones without any.  The dearest are printed, and all are
written to TIMES.json by name, the collection of each process among them.

Workers of pytest-xdist load plugins by name alone: that is why this file is both, the command and
the plugin that it hands to pytest.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

FOLDER = "POLHODE_TEST_COSTS"  # where each process writes what it has seen
DEAREST = 20
spent: dict[str, float] = {}


def seconds() -> float:
    """Of this process, all threads, and of its children that have ended."""
    both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in both)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    before = seconds()
    try:
        return (yield)
    finally:
        spent[item.nodeid] = seconds() - before


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection() -> Iterator[None]:
    before = seconds()
    try:
        return (yield)
    finally:
        spent[f"collection by {os.environ.get('PYTEST_XDIST_WORKER', 'one')}"] = seconds() - before


def pytest_sessionfinish() -> None:
    Path(os.environ[FOLDER], f"{os.getpid()}.json").write_text(json.dumps(spent))


def main(target: Path, arguments: list[str]) -> int:
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-p", "costs", *arguments],
            env={**os.environ, FOLDER: folder, "PYTHONPATH": str(Path(__file__).parent)},
        )
        for part in Path(folder).iterdir():
            found |= json.loads(part.read_text())
    target.write_text(json.dumps(found, indent=0, sort_keys=True))
    for name in sorted(found, key=found.__getitem__, reverse=True)[:DEAREST]:
        print(f"{found[name]:7.2f} s  {name}")
    print(f"{sum(found.values()):7.2f} s  in all")
    return done.returncode


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1]), sys.argv[2:]))
