"""Every verb met by a signal at a random moment of its processor time, as a process of its own.

SIGINT and SIGTERM, to the process or as from a terminal to its whole group: it ends within SECONDS
of the clock, or where the machine is busy of its processor time, with exit code 130 or the one that
it had already, no more on stderr than lines of its own, and nothing left but what is documented:
parts to go on from, a sweep's members, and its file if that was written before, whole.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path
from random import Random
from typing import NamedTuple

from polhode.results.reader import kind_at
from shared.motions import heavy_file

SECONDS = 5.0
HANGS = 120.0  # seconds of the clock after which a command never ends
OBEYED = (signal.SIGINT, signal.SIGTERM)

#: ``polhode``, but that it tells when it is ready for signals, and keeps parts of a sweep often.
READY = """
import os, sys
from polhode import cli
from polhode.common import checkpoint
from polhode.verbs import terminal
checkpoint.EVERY = 0.02
prepare = terminal.prepare
def announced():
    prepare()
    os.write(int(reader_of), b"!")
terminal.prepare = announced
reader_of = sys.argv.pop(1)
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
    "certified": "certify R --digits 60 --at 20000",
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
    "report": "report C --end 300 -o x.html",
    "levels": "levels R --f-range=-1e12:1e12 -o x.svg",
    "section": "section C --grid 40x40 --crossings 3000 -o x.npz",
    "section-alone": "section C --grid 30x30 --crossings 500 --workers 1",
    "section-pole": "section R --by p-1e-4/(r*r+1e-12) --crossings 3000",
    "map": "map C --grid 100x100 --end 20000 -o x.npz",
    "map-far": "map C --grid 2x2 --end 1e5 --h 40 --f 0 -o x.npz",
    "orbits": "orbits C --grid 12x12",
    "orbit-search": "orbits C --grid 12x12 --pick 1",
    "prove": "prove orbits C --grid 12x12",
    "prove-digits": "prove orbit grioli/precession --digits 200",
    "orbit-digits": "orbit grioli/precession --digits 300",
    "orbit-period": "orbit R --period 1e9",
    "orbit-family": "family grioli/precession --by h --to 50 -o x.npz",
    "order": "order given.csv given.csv given.toml --steps 2,1",
    "frequencies": "frequencies R --end 10000 --lines 30",
    "view": "view R --end 1000 --digits 40 -o x.html",
    "show": "show kovalevskaya/generic",
    "list": "list",
    "guide": "guide jobs",
}
QUICK = ("show", "list", "guide")
_NAMES = {"R": "general/asymmetric-regular", "C": "general/asymmetric-chaotic"}
#: What a command may leave that was ended by a signal; a sweep its members, too.
LEFT = re.compile(
    r"x\.npz\.parts(/.*)?|out(/[\w.-]+\.parts.*|/\w+-[\w-]+\.(csv|certificate\.json))?"
)
#: How a whole file ends, by its name's ending: a signal may come between it and the last line.
ENDS = {".svg": b"</svg>\n", ".png": b"IEND\xaeB`\x82", ".gif": b";", ".html": b"</html>\n"}
SAID = re.compile(r"(polhode: [^\n]+\n|[\w/.-]+: [^\n]+\n)*")
#: The second is a million times faster about one axis than its start says.
_GIVEN = {
    "given.toml": heavy_file("3000", "1", 3001, moments="2, 1.5, 1"),
    "thin.toml": heavy_file("3000", '"3.7e-5"', 3001, "6.641e5", '"4.264e-7", 1, 1'),
}


class Ended(NamedTuple):
    """How a command ended: its code (None: it had to be killed), seconds, and what it said."""

    code: int | None
    seconds: float  # of the clock, or of the processor where that is less, after the signal
    alive: bool  # processes of it were left behind
    out: str
    err: str


def carried_out(command: str, moment: float = HANGS, by: int = 0, group: bool = False) -> Ended:
    """A command in the present folder, and a signal once it has used so many seconds."""
    reader, writer = os.pipe()
    words = [_NAMES.get(word, word) for word in command.split()]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(
            [sys.executable, "-c", READY, str(writer), *words],
            stdout=out,
            stderr=err,
            pass_fds=[writer],
            start_new_session=True,
        )
        os.close(writer)
        os.read(reader, 1)
        os.close(reader)
        last = time.monotonic() + HANGS
        while process.poll() is None and _cpu(process.pid) < moment and time.monotonic() < last:
            time.sleep(0.02)
        before, began = _cpu(process.pid), time.monotonic()
        if process.returncode is None and by:
            (os.killpg if group else os.kill)(process.pid, by)
        cpu = before
        while process.poll() is None and time.monotonic() < began + HANGS:
            cpu = max(cpu, _cpu(process.pid))
            time.sleep(0.02)
        seconds, code = min(time.monotonic() - began, cpu - before), process.returncode
        alive = code is None or (by != signal.SIGKILL and _alive(process.pid))
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        said = []
        for stream in (out, err):
            stream.seek(0)
            said.append(stream.read().decode())
    return Ended(code, seconds, alive, *said)


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


def whole(path: Path) -> bool:
    """Whether a file is one that a command writes, to its end."""
    if path.name.startswith("x.csv"):
        return bool(kind_at(Path("x.csv")))
    if path.suffix == ".npz":
        with contextlib.suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(path) as packed:
            return packed.testzip() is None
        return False
    return path.suffix in ENDS and path.read_bytes().endswith(ENDS[path.suffix])


def prepare(work: str) -> None:
    """The files that a command reads, in the present folder."""
    for name, text in _GIVEN.items():
        Path(name).write_text(text)
    if "given.csv" in WORKS[work]:
        run = [sys.executable, "-m", "polhode", "run", "given.toml", "-o", "given.csv"]
        subprocess.run(run, check=True, capture_output=True)


def faults_of(work: str, ended: Ended, by: int) -> list[str]:
    """What is wrong with how a work ended, in the folder where it did."""
    faults = []
    if ended.code not in (0, 3, 130):
        faults.append(f"exit code {ended.code}")
    if ended.seconds > SECONDS:
        faults.append(f"ended after {ended.seconds:.1f} s")
    if ended.alive:
        faults.append("processes left behind")
    lines = ended.err.count("\n")
    if not SAID.fullmatch(ended.err) or lines > 3 or (ended.code == 130 and not lines):
        faults.append(f"said {ended.err[-1500:]!r}")
    if ended.code == 130:
        mine = ("given.csv", "given.csv.json", *_GIVEN)
        left = [path for path in Path().rglob("*") if path.name not in mine]
        swept = {"x.npz"} if "sweep" in work else set()
        may = [path for path in left if LEFT.fullmatch(str(path)) or str(path) in swept]
        faults += [f"left {path}" for path in left if path not in may and not whole(path)]
    return faults


def met_at_random(
    work: str, moments: int, seed: int, signals: tuple[int, ...] = OBEYED, longest: float = 8.0
) -> tuple[list[int | None], list[str]]:
    """A work met by so many signals, each in a folder of its own: how it ended, and the faults."""
    random, codes, faults = Random(f"{work} {seed}"), [], []
    longest = 1.0 if work in QUICK else longest
    for _ in range(moments):
        by, moment = random.choice(signals), longest * random.random()
        group = by == signal.SIGINT and random.random() < 0.5
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            prepare(work)
            ended = carried_out(WORKS[work], moment, by, group)
            these = faults_of(work, ended, by)
        codes.append(ended.code)
        faults += [f"{signal.Signals(by).name} after {moment:.2f} s: {fault}" for fault in these]
    return codes, faults
