"""What each test costs: seconds of processor time, its fixtures and child processes included.

    python tests/measure/costs.py TIMES.json [PYTEST ARGUMENTS...]

Wall clock says little where other work shares the machine; processor time says more.  Arguments
of pytest choose the tests, the fast ones without any.  The dearest are printed, and the fast ones
that take more than they may; all are written to TIMES.json by name, the collection of each process
among them.  The exit code is pytest's: a slow machine fails nothing.

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
MOST = 0.6  # seconds that a fast test may take
spent: dict[str, float] = {}
fast: set[str] = set()


def seconds() -> float:
    """Of this process, all threads, and of its children that have ended."""
    both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in both)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    before = seconds()
    if not item.get_closest_marker("slow"):
        fast.add(item.nodeid)
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
    times = {"all": spent, "fast": {name: spent[name] for name in fast}}
    Path(os.environ[FOLDER], f"{os.getpid()}.json").write_text(json.dumps(times))


def main(target: Path, arguments: list[str]) -> int:
    every: dict[str, float] = {}
    quick: dict[str, float] = {}
    paths = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-p", "costs", *arguments],
            env={**os.environ, FOLDER: folder, "PYTHONPATH": os.pathsep.join(paths)},
        )
        for part in Path(folder).iterdir():
            times = json.loads(part.read_text())
            every |= times["all"]
            quick |= times["fast"]
    target.write_text(json.dumps(every, indent=0, sort_keys=True))
    show(dict(sorted(every.items(), key=lambda item: -item[1])[:DEAREST]))
    dear = {name: spent for name, spent in quick.items() if spent > MOST}
    print(f"{sum(every.values()):7.2f} s  in all, {sum(quick.values()):.0f} s of them fast tests")
    print(f"{len(dear)} fast tests take more than {MOST} s:" if dear else "no fast test is dear")
    show(dear)
    return run.returncode


def show(times: dict[str, float]) -> None:
    for name in sorted(times, key=times.__getitem__, reverse=True):
        print(f"{times[name]:7.2f} s  {name}")


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1]), sys.argv[2:]))
