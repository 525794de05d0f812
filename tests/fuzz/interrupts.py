"""Every verb met by a signal: ``python -m fuzz.interrupts NAME,NAME|all MOMENTS [SEED]`` in tests/.

A command that runs long is started as a process of its own, and at a random moment of its
processor time SIGINT or SIGTERM comes: to the process, or to its whole group as from a terminal.
It ends within SECONDS of the clock, or where the machine is busy of its processor time; with exit
code 130, or the one that it had already; with no more on stderr than lines of its own; and it
leaves nothing but what is documented: parts to go on from, a sweep's members, and its file if that
was written before the signal came, whole.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections import Counter
from pathlib import Path
from random import Random
from typing import NamedTuple

SECONDS = 5.0
HANGS = 120.0  # seconds of the clock after which a command never ends
LONGEST = 8.0  # seconds of the processor after which a signal comes, at most

#: ``polhode``, but that it tells when it is ready for signals.
TOLD = """
import os, sys
from polhode import cli
from polhode.verbs import terminal
prepare = terminal.prepare
def told():
    prepare()
    os.write(int(told_to), b"!")
terminal.prepare = told
told_to = sys.argv.pop(1)
sys.argv[0] = "polhode"
cli.command()
"""

#: Commands that run long, R for a regular motion and C for a chaotic one; and those that do not.
WORKS = {
    "run": "run C --at 1e9 --max-steps 10000000000 -o x.csv",
    "run-many-outputs": "run R --at 1e5 --outputs angles,attitude",
    "run-digits": "run R --digits 200 --at 300 -o x.csv",
    "run-quad": "run R --number quad --at 1e5",
    "reference": "reference kovalevskaya/generic --digits 3000",
    "certified": "reference R --certified --digits 60 --at 20000",
    "check": "check euler/* kovalevskaya/* hard/*",
    "compare": "compare given.csv given.toml",
    "sweep": "sweep R --vary start.omega[3]=1:4:100000 -o x.npz",
    "sweep-fast": "sweep R --vary start.omega[3]=1e5,1 --at 1e4 --max-steps 100000000000",
    "sweep-thin": "sweep thin.toml --vary start.omega[3]=1,2,3 --at 1e5 --max-steps 100000000000",
    "sweep-thin-rows": "sweep thin.toml --vary start.omega[3]=1,2 --at 1,2,3e5 --number extended"
    " --max-steps 100000000000",
    "sweep-lyapunov": "sweep R --vary start.omega[3]=1,2 --at 1e7 --keep lyapunov",
    "plot": "plot R --what error --end 1e4 -o x.svg",
    "plot-integrals": "plot R --what integrals --end 1e8 -o x.png",
    "film": "plot R --what motion --end 300 -o x.gif",
    "study": "study stability --quick -o out",
    "study-speed": "study speed --quick -o out",
    "levels": "levels R --f=-1e12:1e12 -o x.svg",
    "section": "section C --grid 40x40 --crossings 3000 -o x.npz",
    "section-alone": "section C --grid 30x30 --crossings 500 --workers 1",
    "section-pole": "section R --by p-1e-4/(r*r+1e-12) --crossings 3000",
    "map": "map C --grid 100x100 --end 20000 -o x.npz",
    "map-far": "map C --grid 2x2 --end 1e5 --h 40 --f 0 -o x.npz",
    "orbit": "orbit C --search 12x12",
    "prove": "prove orbit C --search 12x12",
    "prove-digits": "prove orbit grioli/precession --digits 200",
    "orbit-digits": "orbit grioli/precession --digits 400",
    "orbit-period": "orbit R --period 1e9",
    "orbit-family": "orbit grioli/precession --continue h=50 -o x.npz",
    "frequencies": "frequencies R --end 10000 --lines 30",
    "view": "view R --end 1000 --digits 40 -o x.html",
    "benchmark": "benchmark -o out",
    "show": "show kovalevskaya/generic",
    "list": "list",
    "guide": "guide jobs",
}
_NAMES = {"R": "general/asymmetric-regular", "C": "general/asymmetric-chaotic"}
#: What a command may leave that was ended by a signal.
LEFT = re.compile(
    r"x\.npz\.parts(/.*)?|out(/[\w.-]+\.parts.*|/\w+-[\w-]+\.(csv|certificate\.json))?"
)
SWEPT = re.compile(r"x\.npz")
#: How a whole file ends, by its name's ending: a signal may come between it and the last line.
ENDS = {".svg": b"</svg>\n", ".png": b"IEND\xaeB`\x82", ".gif": b";", ".html": b"</html>\n"}
SAID = re.compile(r"(polhode: [^\n]+\n|[\w/.-]+: [^\n]+\n)*")
_OURS = ("given.", "thin.")
_GIVEN = """
schema = 1
[body]
moments = [2, 1.5, 1]
centre = [0.3, 0.2, 1]
weight = 1
[start]
gamma = ["4/5", "3/5", 0]
omega = [1, 0.2, 1]
[run]
end = 3000
samples = 3001
"""
#: A body that is a million times faster about one axis than its start says.
_THIN = """
schema = 1
[body]
moments = ["4.264e-7", 1, 1]
centre = [0.3, 0.2, 1]
weight = "6.641e5"
[start]
gamma = ["3/5", 0, "4/5"]
omega = ["7.3e-5", 0.38, "3.7e-5"]
"""


class Trial(NamedTuple):
    """One signal: the exit code, seconds of the clock and of the processor to the end, faults."""

    code: int
    seconds: float
    cpu: float
    faults: list[str]


def trial(work: str, moment: float, by: int, group: bool) -> Trial:
    """A work of WORKS in the present folder, and a signal once it has used so many seconds."""
    heard, told = os.pipe()
    words = [_NAMES.get(word, word) for word in WORKS[work].split()]
    with tempfile.TemporaryFile() as err:
        process = subprocess.Popen(
            [sys.executable, "-c", TOLD, str(told), *words],
            stdout=subprocess.DEVNULL,
            stderr=err,
            pass_fds=[told],
            start_new_session=True,
        )
        os.close(told)
        os.read(heard, 1)
        os.close(heard)
        last = time.monotonic() + HANGS
        while process.poll() is None and _cpu(process.pid) < moment and time.monotonic() < last:
            time.sleep(0.02)
        before, began = _cpu(process.pid), time.monotonic()
        if process.returncode is None:
            (os.killpg if group else os.kill)(process.pid, by)
        code, cpu = _ended(process, began + HANGS)
        seconds, cpu = time.monotonic() - began, cpu - before
        err.seek(0)
        said = err.read().decode()
    faults = []
    if code is None:
        code = -9
        faults.append(f"still there after {seconds:.0f} s")
    elif code not in (0, 3, 130):
        faults.append(f"exit code {code}")
    if seconds > SECONDS and cpu > SECONDS:
        faults.append(f"ended after {seconds:.1f} s, {cpu:.1f} s of the processor")
    if _alive(process.pid):
        faults.append("processes left behind")
        os.killpg(process.pid, signal.SIGKILL)
    if not SAID.fullmatch(said) or said.count("\n") > 3 or (code == 130 and not said):
        faults.append(f"said {said[-1500:]!r}")
    if code == 130:
        faults += [f"left {path}" for path in _left() if not _may_stay(work, path)]
    return Trial(code, seconds, cpu, faults)


def _ended(process: subprocess.Popen[bytes], last: float) -> tuple[int | None, float]:
    """The exit code, None of one that had to be killed, and the processor's seconds in all."""
    if process.returncode is not None:
        return process.returncode, 0.0
    code: int | None = None
    while True:
        pid, status, used = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        if time.monotonic() > last:
            os.killpg(process.pid, signal.SIGKILL)
            _, _, used = os.wait4(process.pid, 0)
            process.returncode = -9
            return None, used.ru_utime + used.ru_stime
        time.sleep(0.02)
    process.returncode = code = os.waitstatus_to_exitcode(status)
    return code, used.ru_utime + used.ru_stime


def _cpu(group: int) -> float:
    """Processor time so far, of all processes of the group and the children they waited for.

    Work that waits for its workers uses none itself: its signal would come when it has hung.
    """
    ticks = 0
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it ended meanwhile
        if int(fields[2]) == group:
            ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def _alive(group: int) -> bool:
    """Whether a process of the group lives on, a moment after its first one ended."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.05)
    return True


def _left() -> list[str]:
    return [str(path) for path in Path().rglob("*") if not path.name.startswith(_OURS)]


def _may_stay(work: str, path: str) -> bool:
    return bool(
        LEFT.fullmatch(path)
        or (work.startswith("sweep") and SWEPT.fullmatch(path))
        or whole(Path(path))
    )


def whole(path: Path) -> bool:
    """Whether a file is one that a command writes, to its end."""
    if path.suffix == ".npz":
        with contextlib.suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(path) as held:
            return held.testzip() is None
        return False
    return path.suffix in ENDS and path.read_bytes().endswith(ENDS[path.suffix])


def sampled(work: str, moments: int, seed: int = 0) -> tuple[Counter[str], list[str]]:
    """A work met by so many signals, each in a folder of its own: how it ended, and the faults."""
    random = Random(f"{work} {seed}")
    counts, faults = Counter[str](), []
    longest = 1.0 if work in ("show", "list", "guide") else LONGEST
    for _ in range(moments):
        by, group = random.choice([signal.SIGINT, signal.SIGTERM]), random.random() < 0.3
        moment = longest * random.random()
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            if "thin" in work:
                Path("thin.toml").write_text(_THIN)
            if work == "compare":
                Path("given.toml").write_text(_GIVEN)
                given = [sys.executable, "-m", "polhode", "run", "given.toml", "-o", "given.csv"]
                subprocess.run(given, check=True, capture_output=True)
            found = trial(work, moment, by, group and by == signal.SIGINT)
        counts[f"{found.code}"] += 1
        counts["slowest"] = max(counts["slowest"], round(1000 * min(found.seconds, found.cpu)))
        name = signal.Signals(by).name + (" to the group" if group else "")
        faults += [f"{work}, {name} after {moment:.2f} s: {fault}" for fault in found.faults]
    return counts, faults


def main() -> None:
    """Signals to some works; counts and faults on stdout, exit code 1 where there was a fault."""
    names = [*WORKS] if sys.argv[1] == "all" else sys.argv[1].split(",")
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    bad = False
    for name in names:
        counts, faults = sampled(name, int(sys.argv[2]), seed)
        slowest = counts.pop("slowest")
        print(name, dict(sorted(counts.items())), f"slowest {slowest / 1000:.2f} s", flush=True)
        print(*(f"== {fault}\n" for fault in faults), sep="", end="", flush=True)
        bad |= bool(faults)
    sys.exit(bad)


if __name__ == "__main__":
    main()
