"""Numbers hundreds of powers of ten apart: every verb ends in one line, and none in a traceback."""

from __future__ import annotations

import warnings

import pytest

import polhode
from polhode.cli import main

SCENE = """schema = 1
[body]
moments = [{moments}]
centre = [{centre}]
weight = "{weight}"
[start]
omega = [0.1, 0.2, 3]
gamma = ["3/5", 0, "4/5"]
[run]
end = 10
samples = 5
"""
BODIES = {
    "a moment near zero": ('1, 1, "1e-300"', "0.1, 0, 1", "1"),
    "another one": ('1, "1e-300", 1', "0.1, 0, 1", "1"),
    "a heavy one": ('"1e300", "1e300", "1e-300"', "0.1, 0.2, 1", "1e300"),
    "small ones": ('"1e-300", "1e-300", "1e-300"', "0, 0, 1", "1"),
    "beyond doubles": ('"1e400", "1e400", "1e400"', '0.1, 0.2, "1e300"', "1e300"),
}
VERBS = {
    "run": [],
    "show": [],
    "check": [],
    "reference": ["--digits", "10"],
    "sweep": ["--vary", "start.omega[3]=1:2:2", "--workers", "1"],
    "plot": ["--what", "omega", "-o", "x.svg"],
    "view": ["-o", "x.html"],
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("body", BODIES)
def test_every_verb_ends_in_one_line(body, verb, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    moments, centre, weight = BODIES[body]
    text = SCENE.format(moments=moments, centre=centre, weight=weight)
    (tmp_path / "x.toml").write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of matplotlib's own, of numbers like these
        code = main([verb, "x.toml", *VERBS[verb]])
    told = capsys.readouterr()
    assert code in (0, 2, 3)
    if code == 2:
        assert [line.startswith("polhode: ") for line in told.err.splitlines()].count(True) == 1
        assert len(told.err.splitlines()) <= 2  # one may tell of the window that is drawn
    if code == 3:
        assert "undefined" in told.err or "step" in told.err


def test_a_step_of_no_length_ends_the_run_where_it_began():
    top = polhode.top(
        moments=[1, 1, "1e-300"],
        centre=["0.1", 0, 1],
        weight=1,
        omega=["0.1", "0.2", 3],
        gamma=["3/5", 0, "4/5"],
    )
    for number in ("double", "quad"):
        run = polhode.integrate(top, number, at=[0, 10])
        assert run.outcome is polhode.Outcome.NON_FINITE
        assert run.times == (0,)
        assert 0 <= run.reached < 1


def test_so_many_events_that_compiling_would_not_end_are_refused(tmp_path, capsys):
    text = SCENE.format(moments="1, 2, 2", centre="1, 0, 0", weight="1")
    event = '[[events]]\nname = "e{0}"\nzero = "gamma3 - {0}/1000"\n'
    path = tmp_path / "x.toml"
    path.write_text(text + "".join(event.format(k) for k in range(101)))
    assert main(["run", str(path)]) == 2
    assert capsys.readouterr().err.endswith("events = 101 events: expected at most 100\n")
