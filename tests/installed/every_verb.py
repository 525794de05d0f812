"""Every verb once, in an installed wheel: what users have, and what a checkout does not show.

Makes a wheel of this checkout, which has to have every file of the package, and an environment of
its own, in a folder that is removed at the end; installs the wheel with what the first command of
the README installs, and runs the examples of all verbs and the commands below from an empty
folder, as a user who never ran polhode; then installs what figures need, and runs
those that draw.  A command fails by another exit code than the one beside it, by a traceback or a
warning.  Exit code 0 if all passed.

    python3 tests/installed/every_verb.py
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]

#: Exit codes and commands, before and after the examples of all verbs.
BARE = ((0, ""), (0, "--version"), (0, "guide"), (0, "guide python"), (2, "show lagrange/nutaton"))
AFTER = (
    (2, "order top.csv top.csv top.toml"),
    (0, "verify orbit.json"),
    (0, "verify stability.json"),
)
#: Examples that end otherwise where nothing draws and no table of another program is, and the one
#: that takes minutes.
CODES = {"plot": 2, "order": 2}
LONG = {"prove chaos"}
#: Commands that draw.
WITH_FIGURES = (
    (0, "plot top.toml --what omega -o top.svg"),
    (0, "plot top.csv --what omega -o omega.png"),
    (0, "plot top.toml --what motion --end '0.1 s' -o top.gif"),
    (0, "levels grioli/precession -o levels.svg"),
    (0, "report top.toml top.csv -o report.html -o report.json"),
    (0, "section general/section --grid 2x2 --crossings 2 -o section.svg"),
)
#: A process that ends by itself is not waited for where its parent is interrupted.
WARNINGS = "default,ignore::ResourceWarning"


def main() -> int:
    """Install, run all, and say how many passed."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background has none
    with tempfile.TemporaryDirectory(prefix="polhode-installed-") as name:
        place = Path(name)
        home, user = place / "home", place / "user"
        home.mkdir()
        user.mkdir()
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "XDG"))}
        environment |= {"HOME": str(home), "PYTHONWARNINGS": WARNINGS}
        run([sys.executable, "-m", "venv", str(place / "venv")])
        python = str(place / "venv" / "bin" / "python")
        pip = [python, "-m", "pip", "--quiet", "--disable-pip-version-check"]
        run([*pip, "wheel", "--no-deps", "-w", str(place), str(TOP)])
        (wheel,) = place.glob("*.whl")
        run([*pip, "install", "--no-compile", str(wheel)])
        rows = [*BARE, *examples(python, user, environment), *AFTER]
        faults = [*missing(wheel)]
        faults += [f for row in rows for f in faults_of(python, *row, user, environment)]
        run([*pip, "install", "--no-compile", f"{wheel}[figures]"])
        faults += [f for row in WITH_FIGURES for f in faults_of(python, *row, user, environment)]
    count = len(rows) + len(WITH_FIGURES)
    print("\n".join(faults) or f"installed: {count} commands passed")
    return 1 if faults else 0


def run(command: list[str]) -> None:
    """A step of the installation."""
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def missing(wheel: Path) -> list[str]:
    """Files of the package that the wheel has not."""
    package = TOP / "src" / "polhode"
    own = {x.relative_to(TOP / "src").as_posix() for x in package.rglob("*") if x.is_file()}
    with zipfile.ZipFile(wheel) as archive:
        lacking = own - {*archive.namelist()}
    return [f"FAIL {x}: not in the wheel" for x in sorted(lacking) if "__pycache__" not in x]


def examples(python: str, folder: Path, environment: dict[str, str]) -> list[tuple[int, str]]:
    """The example of each verb of the package that is installed."""
    question = (
        "import json, polhode; from polhode.verbs.catalogue import ROWS; "
        "print(json.dumps([polhode.__file__, {x.name: x.command for x in ROWS}]))"
    )
    process = subprocess.run(
        [python, "-c", question],
        cwd=folder,
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    file, commands = json.loads(process.stdout)
    if "site-packages" not in file:
        raise SystemExit(f"FAIL {file} is not installed")
    return [
        (CODES.get(verb, 0), command.removeprefix("polhode "))
        for verb, command in commands.items()
        if verb not in LONG
    ]


def faults_of(
    python: str, expected: int, command: str, folder: Path, environment: dict[str, str]
) -> list[str]:
    """What is wrong with a command, if anything."""
    began = time.monotonic()
    process = subprocess.run(
        [str(Path(python).with_name("polhode")), *shlex.split(command)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    seconds, notes = time.monotonic() - began, process.stderr
    wrong = process.returncode != expected or "Traceback" in notes or "Warning" in notes
    print(
        f"{'FAIL' if wrong else 'ok  '} {seconds:5.1f} s  {f'polhode {command}'.strip()}",
        flush=True,
    )
    if not wrong:
        return []
    code = f"FAIL polhode {command}: exit code {process.returncode}, expected {expected}"
    return ["\n".join([code, *process.stdout.splitlines()[-3:], *notes.splitlines()[-12:]])]


if __name__ == "__main__":
    sys.exit(main())
