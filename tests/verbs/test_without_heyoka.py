"""Where heyoka is not installed: what integrates says so in one line, the rest works."""

from __future__ import annotations

import subprocess
import sys

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


@pytest.mark.parametrize("command", ["run lagrange/nutation", "section general/asymmetric-regular"])
def test_what_integrates_says_how_to_get_it(command):
    code, out, err = said(*command.split())
    assert (code, out) == (2, "")
    assert err.startswith("polhode: heyoka: expected to be installed")
    assert len(err.splitlines()) == 1
