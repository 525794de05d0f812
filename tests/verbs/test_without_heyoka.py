"""Where heyoka is not installed: what integrates says so in one line, the rest works."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

HIDDEN = "import sys; sys.modules['heyoka'] = None; from polhode.cli import command; command()"


def said(*arguments):
    done = subprocess.run(
        [sys.executable, "-c", HIDDEN, *arguments], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    "command",
    [
        "list",
        "about",
        "show lagrange/nutation",
        "reference lagrange/nutation --at 1",
        "levels lagrange/nutation",
        "guide scene",
    ],
)
def test_what_needs_no_heyoka_works(command):
    code, out, err = said(*command.split())
    assert (code, err) == (0, "")
    assert out


def test_a_scene_can_be_made(tmp_path):
    assert said("new", str(tmp_path / "top.toml"))[0] == 0


@pytest.mark.slow
def test_tables_are_judged_against_closed_forms_drawn_and_animated(tmp_path):
    table = str(tmp_path / "mine.csv")
    code, out, _ = said("reference", "lagrange/nutation", "--at", "0,1,2", "--digits", "20")
    header, *rows = (line.split() for line in out.splitlines())
    assert code == 0
    Path(table).write_text("".join(",".join(row) + "\n" for row in [header, *rows]))
    code, out, err = said("compare", table, "lagrange/nutation", "--as-it-stands")
    assert (code, err) == (0, "")
    assert 20 < float(re.search(r"worst (\S+) correct digits", out)[1]) < 27  # 20 and a few guards
    assert "not judged: what limits the digits was not computed: heyoka is not installed" in out
    for verb in (
        ["plot", table, "--what", "omega"],
        ["view", table, "--scene", "lagrange/nutation"],
    ):
        path = tmp_path / f"{verb[0]}.{'png' if verb[0] == 'plot' else 'html'}"
        assert said(*verb, "-o", str(path))[0] == 0
        assert path.stat().st_size > 1000


@pytest.mark.slow
def test_every_public_name_is_there_and_what_integrates_says_how_to_get_it_in_python():
    script = (
        "import sys; sys.modules['heyoka'] = None; import polhode\n"
        "for name in polhode.__all__: getattr(polhode, name)\n"
        "try: polhode.integrate('lagrange/nutation')\n"
        "except ImportError as fault: print(fault)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("heyoka: expected to be installed")
    assert len(done.stdout.splitlines()) == 1


@pytest.mark.parametrize("command", ["run lagrange/nutation", "section general/asymmetric-regular"])
def test_what_integrates_says_how_to_get_it(command):
    code, out, err = said(*command.split())
    assert (code, out) == (2, "")
    assert err.startswith("polhode: heyoka: expected to be installed")
    assert len(err.splitlines()) == 1
