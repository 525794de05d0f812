"""Every verb once, in an installed wheel: what users have, and what a checkout does not show.

Makes a wheel of this checkout, which has to have every file of the package, and an environment of
its own, in a folder that is removed at the end; installs the wheel with what the first command of
the README installs, and runs the commands below from an empty folder, as a user who never ran
polhode; then installs what figures and the report need, and runs those that draw.  A command fails
by another exit code than the one beside it, by a traceback or a warning.  Exit code 0 if all
passed.

    python3 tests/installed/every_verb.py
"""

from __future__ import annotations

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

#: Exit codes and commands, each in the folder that those before it leave.
BARE = (
    (0, ""),
    (0, "--version"),
    (0, "about"),
    (0, "guide"),
    (0, "guide judging"),
    (0, "guide python"),
    (0, "list --tag chaotic"),
    (0, "show lagrange/nutation"),
    (2, "show lagrange/nutaton"),
    (0, "new cone.toml --cone '3 cm,5 cm,50 g' --end '0.5 s'"),
    (0, "run cone.toml -o cone.csv"),
    (0, "compare cone.csv cone.toml"),
    (2, "order cone.csv cone.csv cone.toml"),
    (0, "report cone.toml cone.csv=1ms -o cone.md"),
    (0, "run euler/separatrix --digits 30 --at 1"),
    (0, "reference euler/separatrix --digits 40 --at 1"),
    (0, "certify general/asymmetric-regular --at 1 -o certificate.json"),
    (0, "verify certificate.json"),
    (0, "check euler/rest"),
    (0, "sweep general/asymmetric-regular --vary start.omega[1]=0:1:5 --at 0,1 -o sweep.csv"),
    (0, "view cone.toml -o cone.html"),
    (0, "levels grioli/precession"),
    (0, "section general/section --grid 2x2 --crossings 2 -o section.npz"),
    (0, "map general/section --grid 2x2 --end 10 -o map.npz"),
    (0, "orbit grioli/precession"),
    (0, "orbits general/asymmetric-regular --grid 4x4 --crossings 1 -o orbits.csv"),
    (0, "family grioli/precession --by h --to 0.84 -o family.json"),
    (0, "prove orbit grioli/precession -o orbit.json"),
    (0, "verify orbit.json"),
    (0, "prove stability general/asymmetric-regular -o stability.json"),
    (0, "verify stability.json"),
    (0, "frequencies lagrange/nutation --end 20"),
    (2, "plot cone.toml --what angles -o cone.svg"),
)
#: Commands that draw.
WITH_FIGURES = (
    (0, "plot cone.toml --what angles -o cone.svg"),
    (0, "plot cone.csv --what omega -o omega.png"),
    (0, "plot cone.toml --what motion --size 200 --fps 5 --end '0.1 s' -o cone.gif"),
    (0, "levels grioli/precession -o levels.svg"),
    (0, "report cone.toml cone.csv -o cone.html -o report.json"),
    (0, "section general/section --grid 2x2 --crossings 2 -o section.svg"),
)
#: A process that ends by itself is not waited for where its parent is interrupted.
WARNINGS = "default,ignore::ResourceWarning"
#: Seconds after which a command that is to be interrupted is.
PATIENCE = 5


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
        faults = [*missing(wheel), *unnamed(python, user, environment)]
        faults += [f for row in BARE for f in told(python, *row, user, environment)]
        run([*pip, "install", "--no-compile", f"{wheel}[report]"])
        faults += [f for row in WITH_FIGURES for f in told(python, *row, user, environment)]
    count = len(BARE) + len(WITH_FIGURES)
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


def unnamed(python: str, folder: Path, environment: dict[str, str]) -> list[str]:
    """Verbs without a command here; and whether the package that runs is the one installed."""
    question = "import polhode.cli as cli; print(cli.__file__, *cli.VERBS)"
    done = subprocess.run(
        [python, "-c", question],
        cwd=folder,
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    file, *verbs = done.stdout.split()
    called = {command.partition(" ")[0] for _, command in (*BARE, *WITH_FIGURES)}
    faults = [f"FAIL {verb}: no command of it is run here" for verb in verbs if verb not in called]
    return faults if "site-packages" in file else [*faults, f"FAIL {file} is not installed"]


def told(
    python: str, expected: int, command: str, folder: Path, environment: dict[str, str]
) -> list[str]:
    """What is wrong with a command, if anything."""
    began = time.monotonic()
    process = subprocess.Popen(
        [str(Path(python).with_name("polhode")), *shlex.split(command)],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        printed, noted = process.communicate(timeout=PATIENCE if expected == 130 else None)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
        printed, noted = process.communicate()
    seconds = time.monotonic() - began
    wrong = process.returncode != expected or "Traceback" in noted or "Warning" in noted
    print(
        f"{'FAIL' if wrong else 'ok  '} {seconds:5.1f} s  {f'polhode {command}'.strip()}",
        flush=True,
    )
    if not wrong:
        return []
    code = f"FAIL polhode {command}: exit code {process.returncode}, expected {expected}"
    return ["\n".join([code, *printed.splitlines()[-3:], *noted.splitlines()[-12:]])]


if __name__ == "__main__":
    sys.exit(main())
