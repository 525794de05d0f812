"""Killed work: ``python -m fuzz.faults WORK,WORK MOMENTS [SEED]`` in tests/; counts, and faults.

Each work is done once undisturbed.  Then, for SIGKILL, SIGTERM and SIGINT, it is ended at so many
random moments: what it leaves under its outputs' names is whole or not there, and the same command
given again ends with what the undisturbed one gave, but for timings.  Children are forked from a
process that has imported everything, so that the moments fall into the work itself.
"""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

from polhode import cli
from polhode.runs.sweep import sweep_checkpoint
from polhode.studies import report

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
VARY = ["--vary", "start.omega[3]=1:4:40", "--vary", "body.weight=1:2:10"]
#: A top whose every number is exact in binary: its files of before are what compare reads.
WORKS: dict[str, list[str]] = {
    "run": ["run", "lagrange/nutation", "--number", "quad", "-o", "x.csv"],
    "compare": ["compare", "given.csv", "lagrange/nutation", "--json"],
    "sweep": ["sweep", "lagrange/nutation", "--number", "extended", *VARY, "-o", "x.npz"],
    "study": ["study", "events", "--quick", "-o", "out"],
    "report": ["report", "--quick", "-o", "out"],
}
_TIMED = {"provenance", "seconds", "about", "made"}  # what differs from run to run


class Ended(NamedTuple):
    """How a command ended: its code (negative: the signal), seconds, and what it said."""

    code: int
    seconds: float
    out: str
    err: str


def done(folder: Path, command: list[str], at: float | None = None, by: int = 0) -> Ended:
    """A command carried out by a forked child in a folder, ended by a signal after a while."""
    begun = time.monotonic()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            _carry_out(folder, command, out.fileno(), err.fileno())
        ended = 0
        while at is not None and not ended and time.monotonic() < begun + at:
            time.sleep(0.001)
            ended, status = os.waitpid(child, os.WNOHANG)
        if not ended:
            if at is not None:
                os.kill(child, by)
            _, status = os.waitpid(child, 0)
        code = os.waitstatus_to_exitcode(status)
        told = []
        for stream in (out, err):
            stream.seek(0)
            told.append(stream.read().decode())
    return Ended(code, time.monotonic() - begun, *told)


def _carry_out(folder: Path, command: list[str], out: int, err: int) -> None:
    code = 99
    try:
        os.chdir(folder)
        os.dup2(out, 1)
        os.dup2(err, 2)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # as cli.main would, at once
        code = cli.main(command)
        sys.stdout.flush()
    except KeyboardInterrupt:  # before or after main itself
        code = 130
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def timeless(value: Any) -> Any:
    """JSON without what differs from run to run."""
    if isinstance(value, dict):
        return {key: timeless(x) for key, x in value.items() if key not in _TIMED}
    return [timeless(x) for x in value] if isinstance(value, list) else value


def contents(path: Path) -> Any:
    """What a whole file says; raises where it is not whole."""
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as held:
            return {name: held[name].tolist() for name in held.files if name not in _TIMED}
    if path.suffix == ".json":
        return timeless(json.loads(path.read_text()))
    text = re.sub(r" in [\d.]+ (second|minute)s?\b", "", path.read_text())
    if path.suffix in (".svg", ".html"):
        text = re.sub(r"<dc:date>.*?</dc:date>|id=\"\w+\"|#\w+", "", text)
    return text


def outputs(folder: Path) -> dict[str, Any]:
    """The files under the names of outputs, and what they say."""
    return {
        str(path.relative_to(folder)): contents(path)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".") and ".parts" not in str(path)
    }


def leftovers(folder: Path) -> list[str]:
    """Temporary files."""
    return [path.name for path in folder.rglob(".*")]


class Trials:
    """The trials of one work: faults as they are found, and counts."""

    def __init__(self, work: str, prepare: Callable[[Path], None]) -> None:
        self.work, self.command, self.prepare = work, WORKS[work], prepare
        self.counts, self.faults = Counter[str](), list[str]()
        folder = self._folder()
        self.whole = done(folder, self.command)
        self.right = outputs(folder), self._said(self.whole)
        assert self.whole.code == 0, self.whole

    def _folder(self) -> Path:
        folder = Path(tempfile.mkdtemp(dir="."))
        self.prepare(folder)
        return folder.resolve()

    def _said(self, ended: Ended) -> Any:
        return timeless(json.loads(ended.out)) if "--json" in self.command else None

    def one(self, moment: float, by: int) -> None:
        """One trial: ended at a share of the undisturbed time, looked at, and given again."""
        folder, name = self._folder(), signal.Signals(by).name
        ended = done(folder, self.command, moment * self.whole.seconds, by)
        self.counts[f"{name} -> {ended.code}"] += 1
        faults = []
        if ended.code not in ({-by, 0} if by == signal.SIGKILL else {130, 0}):
            faults.append(f"exit code {ended.code}")
        if "Traceback" in ended.err:
            faults.append(ended.err)
        try:
            left = outputs(folder)
        except Exception:
            faults.append(f"a file that is not whole: {traceback.format_exc()}")
            left = {}
        for path, said in left.items():
            # a sweep that Ctrl-C ends writes the members that it has
            if said != self.right[0].get(path) and not (self.work == "sweep" and ended.code == 130):
                faults.append(f"{path} differs")
        if by != signal.SIGKILL and leftovers(folder):
            faults.append(f"left behind: {leftovers(folder)}")
        if any(folder.glob("*.parts/part-*")):
            self.counts["went on from parts"] += 1
        again = done(folder, self.command)
        if again.code != 0 or outputs(folder) != self.right[0]:
            faults.append(f"given again: code {again.code}, {again.err[-500:]}")
        elif self._said(again) != self.right[1]:
            faults.append("given again: said something else")
        if any(folder.glob("*.parts")):
            faults.append("parts left behind")
        self.faults += [
            f"{self.work} {name} at {moment:.3f} of {self.whole.seconds:.2f} s: {fault}"
            for fault in faults
        ]


def trials(work: str, moments: int, seed: int) -> Trials:
    """A work ended at so many random moments by each signal, in the present folder."""
    report.STUDIES = ("published",)  # one that ends within seconds
    sweep_checkpoint.EVERY = 0.02
    given: list[Path] = []

    def prepare(folder: Path) -> None:
        if work == "compare":
            if not given:
                made = Path(tempfile.mkdtemp(dir=".")).resolve()
                assert done(made, ["run", "lagrange/nutation", "-o", "given.csv"]).code == 0
                given.append(made / "given.csv")
            (folder / "given.csv").write_bytes(given[0].read_bytes())

    random, found = Random(f"{work} {seed}"), Trials(work, prepare)
    for by in SIGNALS:
        for _ in range(moments):
            found.one(random.random(), by)
    return found


def _imported() -> None:
    """What every work imports, once, but for ``run``: its moments fall into imports, too."""
    import polhode.figures.canvas.canvas
    import polhode.judging.references.reference
    import polhode.output.sweeps
    import polhode.runs.solve
    import polhode.taylor.batches.batch_integrator  # noqa: F401


def main() -> None:
    """Trials of some works; counts on stdout, exit code 1 where there was a fault."""
    names, moments = sys.argv[1].split(","), int(sys.argv[2])
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    bad = False
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in names:
            if name != "run":
                _imported()
            found = trials(name, moments, seed)
            counts = dict(sorted(found.counts.items()))
            print(name, counts, f"{len(found.faults)} faults", flush=True)
            print(*(f"== {fault}" for fault in found.faults), sep="\n", flush=True)
            bad |= bool(found.faults)
        os.chdir("/")
    sys.exit(bad)


if __name__ == "__main__":
    main()
