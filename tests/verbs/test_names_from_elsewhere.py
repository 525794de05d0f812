"""What other programs call a verb, an option or a file: the message names what is meant here."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import polhode
from polhode import cli

CASE = "lagrange/nutation"

MEANT = {
    f"view {CASE} -o x.gif": f"ends in .html, or polhode plot {CASE} --what motion -o x.gif",
    f"view {CASE} -o x.mp4": "--what motion -o x.mp4",
    f"view {CASE} -o x.svg": f"ends in .html, or polhode plot {CASE} --what W -o x.svg",
    f"view {CASE} -o x.txt": "-o: expected a name that ends in .html\n",
    f"plot {CASE} --what angles -o x.gif": ".svg, .png, .pdf; --what motion makes a page or a film",
    "new cone": "polhode new cone.toml --cone RADIUS,HEIGHT,MASS",
    "new disc": "polhode new disc.toml --disc RADIUS,STEM,MASS",
    f"new {CASE}": f"polhode new FILE.toml --like {CASE}",
    f"integrate {CASE}": "VERB = integrate: expected run SCENE",
    "validate table.csv": "expected compare FILE SCENE",
    "help run": "expected polhode --help, or polhode VERB --help",
    "version": "expected polhode --version",
    f"rnu {CASE}": "benchmark, guide, about (did you mean 'run'?)",
    "run nutation.toml": "(did you mean 'lagrange/nutation'?)",
    "run mine": "did you mean the file mine.toml?",
    f"run {CASE} --output x.csv": "option = --output: expected -o, as it is called here",
    f"run {CASE} --rtol 1e-9": "option = --rtol: expected --tol, as it",
    f"run {CASE} --dt 0.1": "option = --dt: expected --every, as it",
    f"run {CASE} --n-jobs 2": "option = --n-jobs: expected --help, --json",  # it has no workers
    f"sweep {CASE} --n-jobs 2 --vary start.omega[1]=1": "expected --workers, as it",
    f"run {CASE} --digit 3": "(did you mean '--digits'?)",
    "prove orbits grioli/precession": "what = orbits: expected orbit, chaos (did you mean 'orbit'",
    "show table.csv": "this is a table, as for polhode compare FILE SCENE",
    "run table.npz": "this is a table, as for polhode compare FILE SCENE",
    "check --propose": "--propose: expected SCENEs to propose bands for",
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(polhode.load(CASE).source)
    for name in ("table.csv", "table.npz"):
        Path(name).write_text("t,p\n0,1\n")


@pytest.mark.parametrize("command", MEANT)
def test_the_message_names_what_is_meant(command, capsys):
    before = {*Path().iterdir()}
    assert cli.main(command.split()) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert MEANT[command] in err
    assert {*Path().iterdir()} == before


def test_what_a_name_stands_for_is_a_verb():
    for name, meant in cli._MEANT.items():
        assert name not in cli.VERBS
        words = meant.removeprefix("polhode ").replace(",", "").split()
        assert words[0] in (*cli.VERBS, "--help", "--version"), name


@pytest.mark.parametrize(
    ("command", "date"),
    [
        (f"plot {CASE} --what angles --end 1 -o x.svg", "x"),
        ("levels grioli/precession -o x.pdf", "9" * 20),
        ("study stability --quick", "1.5"),
    ],
)
def test_a_date_that_is_none_is_refused_before_the_work(command, date, capsys, monkeypatch):
    """matplotlib takes the date of a file from the environment."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", date)
    assert cli.main(command.split()) == 2
    expected = "expected seconds since 1970, a whole number"
    said = f"polhode: environment: SOURCE_DATE_EPOCH = {date}: {expected}\n"
    assert capsys.readouterr().err == said


def test_a_backend_that_matplotlib_has_not_is_refused(monkeypatch):
    """It reads the variable while it is imported, in a process of its own."""
    command = [sys.executable, "-m", "polhode", "plot", CASE, "--what", "angles", "-o", "x.svg"]
    environment = {**os.environ, "MPLBACKEND": "nonsense"}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True)
    expected = "a backend that matplotlib has, such as agg, or none"
    said = f"polhode: environment: MPLBACKEND = nonsense: expected {expected}\n"
    assert (ended.returncode, ended.stderr) == (2, said)
