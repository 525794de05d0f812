"""Work that is killed, met by a full disk, or done twice at once: whole files or none."""

from __future__ import annotations

import ast
import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from fuzz import faults

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
TESTS = Path(__file__).parents[1]


def trials(work: str, moments: int, seed: int) -> dict[str, int]:
    """Trials in a process of their own, which has no threads; how often what came of them."""
    command = [sys.executable, "-m", "fuzz.faults", work, str(moments), str(seed)]
    told = subprocess.run(command, cwd=TESTS, capture_output=True, text=True)
    assert told.returncode == 0, told.stdout + told.stderr
    first = told.stdout.splitlines()[0]
    counts: dict[str, int] = ast.literal_eval(first[first.index("{") : first.index("}") + 1])
    return counts


@pytest.mark.slow
@pytest.mark.parametrize("work", ["run", "compare", "sweep"])
def test_killed_work_leaves_whole_files_or_none_and_is_done_again(work):
    counts = trials(work, 1, 5)
    assert sum(n for name, n in counts.items() if "->" in name) == len(faults.SIGNALS)


@pytest.mark.campaign
@pytest.mark.parametrize("work", [*faults.WORKS])
def test_killed_at_many_moments(work):
    counts = trials(work, 20, 1)
    assert sum(n for name, n in counts.items() if "->" in name) == 20 * len(faults.SIGNALS)
    assert counts.get("SIGKILL -> -9", 0) > 10


SMALL = ["lagrange/nutation", "--at", "0,1"]
WRITTEN = {
    "run": ["run", *SMALL, "-o", "x.csv"],
    "sweep": ["sweep", *SMALL, "--vary", "start.omega[3]=1:4:40", "-o", "x.npz"],
    "sweep.csv": ["sweep", *SMALL, "--vary", "start.omega[3]=1:4:40", "-o", "x.csv"],
    "plot": ["plot", "lagrange/nutation", "--what", "error", "-o", "x.png"],
}


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("work", [*WRITTEN])
def test_a_full_disk_is_one_line_and_leaves_nothing(work, tmp_path):
    """As a limit on the size of files, which the system meets with the same kind of fault."""

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    (tmp_path / "out").mkdir()
    command = [sys.executable, "-m", "polhode", *WRITTEN[work]]
    with (tmp_path / "err").open("wb") as err:
        ended = subprocess.run(
            command,
            cwd=tmp_path / "out",
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            preexec_fn=full,
            text=True,
        )
        err.write(ended.stderr.encode())
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.splitlines()[-1].startswith("polhode: x.")
    assert "File too large" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.slow
def test_two_reports_into_one_folder_at_once(tmp_path):
    """Both end, and what is there is what one of them alone would have written."""
    code = "from polhode import cli; from polhode.studies import report; "
    code += "report.STUDIES = ('events',); raise SystemExit(cli.main(['report', '--quick', "
    code += "'-o', 'out']))"
    both = [
        subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, stderr=subprocess.PIPE)
        for _ in range(2)
    ]
    for one in both:
        _, err = one.communicate()
        assert one.returncode == 0, err
    found = faults.outputs(tmp_path / "out")
    assert set(found) == {"events.json", "events.md", "events.svg", "report.html"}
    assert json.loads((tmp_path / "out/events.json").read_text())["study"] == "events"
    assert not faults.leftovers(tmp_path)
