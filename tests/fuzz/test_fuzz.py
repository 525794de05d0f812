"""Whatever is given, the promise is kept: cases made from seeds, see :mod:`fuzz.promise`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import polhode
from fuzz import generate, promise
from fuzz.campaign import case
from polhode.common import files
from polhode.output import description
from polhode.runs.sweep import results
from shared.commands import STEPPING

FAST = {"scene": 250, "call": 500, "table": 25, "command": 25}
FAST |= {"archive": 20, "toml": 40, "body": 40, "event": 10, "kept": 10}
FAST |= {"units": 5, "wide": 5, "dynamic": 10, "film": 3, "proof": 3}
MANY = {"scene": 6000, "call": 6000, "table": 1000, "command": 1000}
MANY |= {"archive": 1000, "toml": 2000, "body": 2000, "event": 500, "kept": 500}
MANY |= {"units": 100, "wide": 50, "dynamic": 200, "film": 50, "proof": 50}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    generate.prepared(tmp_path)
    monkeypatch.setattr(description, "SECONDS", 0.05)  # that show looks for frequencies


def kept(kind: str, seeds: range) -> None:
    scene = polhode.load("top.toml")
    for seed in seeds:
        text, faults, _ = case(kind, seed, scene)
        assert not faults, f"{kind} {seed}\n{text[:2000]}\n{faults}"


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*FAST])
def test_the_promise_is_kept(kind):
    kept(kind, range(FAST[kind]))


@pytest.mark.campaign
@pytest.mark.parametrize("kind", [*MANY])
def test_the_promise_is_kept_in_many_cases(kind):
    kept(kind, range(FAST[kind], MANY[kind]))


@pytest.mark.slow
def test_the_generator_makes_what_is_refused_and_what_is_not():
    scene = polhode.load("top.toml")
    for kind, ends in (("scene", {0, 2}), ("call", {True, False})):
        found = {case(kind, seed, scene)[2] for seed in range(200)}
        assert found == ends


# -- the promise's own tests: each kind of fault is seen ------------------------------------------


def fail() -> None:
    raise KeyError("x")


def leave() -> None:
    Path("left").touch()


def loop() -> None:
    while True:
        pass


def spread() -> None:
    raise polhode.BadInput("x", "key", 1, "something") from None


@pytest.mark.parametrize(("work", "told"), [(fail, "KeyError"), (leave, "files changed")])
def test_a_fault_is_seen(work, told):
    faults, _ = promise.of_call(work)
    assert len(faults) == 1
    assert told in faults[0]


def test_work_without_end_is_ended(monkeypatch):
    with pytest.raises(promise.Slow), promise.limited(0.2):
        loop()


def test_a_refusal_is_no_fault():
    assert promise.of_call(spread) == ([], True)


@pytest.mark.parametrize("arguments", [["list", "--no-such"], ["show", "nothing"]])
def test_a_refused_command_is_no_fault(arguments):
    assert promise.of_command(arguments) == ([], 2)


# -- faults that were found, by hand or by the fuzzer ---------------------------------------------


class Nothing:
    """Of no kind that anything takes."""


@pytest.mark.parametrize(
    "call",
    [
        lambda scene: polhode.load(None),
        lambda scene: polhode.load(Nothing()),
        lambda scene: polhode.integrate(scene, 3),
        lambda scene: polhode.integrate(scene, "quad", digits="10"),
        lambda scene: polhode.integrate(scene, max_steps=0),
        lambda scene: polhode.integrate(scene, max_steps="5"),
        lambda scene: polhode.integrate(scene, project="often"),
        lambda scene: polhode.integrate(scene, at=1),
        lambda scene: polhode.integrate(scene, at=["1", None]),
        lambda scene: polhode.integrate(scene, at=[0])(np.array(True)),
        lambda scene: polhode.compare(Nothing(), scene, at=[0]),
        lambda scene: polhode.compare([[1] * 6], Nothing(), at=[0]),
        lambda scene: polhode.compare([[1] * 6], scene, at=0),
        lambda scene: polhode.compare([[1] * 6], scene, at=[0], columns=3),
        lambda scene: polhode.compare([[1] * 6], scene, at=[0], columns=[]),
        lambda scene: polhode.compare([[1] * 3], scene, at=[0], columns=np.eye(3)),
        lambda scene: polhode.compare([[1] * 2], scene, at=[0], columns={"p", "q"}),
        lambda scene: polhode.compare([[1] * 6], scene, at=[0], number=3),
        lambda scene: polhode.integrate_many(scene, 3, at=[0]),
        lambda scene: polhode.integrate_many(scene, iter([1]), at=[0]),
        lambda scene: polhode.lyapunov(scene, float("inf")),
        lambda scene: polhode.rolling(None),
        lambda scene: replace(scene, form=np.array([1, 2])),
        lambda scene: replace(scene, events=(None,)),
        lambda scene: polhode.Body.of_moments([1, 1]),
        lambda scene: polhode.Body([[1, 0], [0, 1]]),
        lambda scene: polhode.load_run(1.5),
        lambda scene: polhode.load_result(None),
        lambda scene: polhode.integrate(scene, at=[0]).save(b"run.npz"),
        lambda scene: polhode.view(scene).save(2),
        lambda scene: polhode.as_toml(1),
        lambda scene: polhode.top(moments=np.bytes_(b"1"), omega=[1, 1, 1]),
        lambda scene: polhode.integrate(scene, at=[np.bytes_(b"1")]),
        lambda scene: polhode.compare(pd.Series([1.0, 2.0]), scene, at=[0, 1]),
        lambda scene: polhode.compare(scene, scene),
        lambda scene: polhode.compare([[1] * 6], scene, at=[0], as_it_stands=pd.NA),
        lambda scene: polhode.section(scene, by=1.5),
        lambda scene: polhode.section(scene, extremum=np.array(["max"])),
        lambda scene: polhode.chaos_map(scene, (2, 2), end=1, parts="folder"),
    ],
)
def test_wrong_types_are_refused_in_one_line(call):
    """They gave TypeErrors from deep inside."""
    scene = polhode.load("top.toml")
    assert promise.of_call(lambda: call(scene)) == ([], True)


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda run: polhode.integrate(run.scene, rtol=1e-9), "rtol = 1e-09: expected tol, as it"),
        (lambda run: polhode.integrate(run.scene, t_eval=[1]), "t_eval = [1]: expected at, as it"),
        (lambda run: polhode.integrate(run.scene, outputs=["angles"]), "a key of the scene"),
        (lambda run: polhode.compare("a.toml", "b.csv"), "polhode compare b.csv a.toml"),
        (lambda run: polhode.integrate(run.scene, end=2), "expected times as at=[...]"),
        (lambda run: polhode.integrate(run.scene, digit=30), "(did you mean 'digits'?)"),
        (lambda run: polhode.integrate(run.scene, dps=9, progress=True), "expected digits, as it"),
        (
            lambda run: polhode.compare(run, at_least=10),
            "polhode.testing.assert_digits(run, scene,",
        ),
        (lambda run: polhode.compare(run, dtype="quad"), "dtype = quad: expected number, as it"),
        (lambda run: polhode.top(moments=[1, 1, 1], omga=[1, 1, 1]), "(did you mean 'omega'?)"),
    ],
)
def test_an_argument_that_has_another_name_here_is_told(call, expected):
    with pytest.raises(polhode.BadInput) as refused:
        call(polhode.integrate("euler/rest", at=[0]))
    assert expected in str(refused.value)


def with_event(zero: str) -> polhode.Scene:
    Path("event.toml").write_text(
        generate.toml(generate.SCENES[0] | {"[events]": {"name": '"x"', "zero": f'"{zero}"'}})
    )
    return polhode.load("event.toml")


@pytest.mark.parametrize(
    ("zero", "pole"), [("1/(t - 0.5)", 0.5), ("sqrt(gamma1 - 0.58)", 0.908334788792443)]
)
def test_an_event_with_a_pole_ends_there(zero, pole):
    """It hung for ever: at a pole heyoka's steps are 0 and count towards no limit."""
    run = polhode.integrate(with_event(zero), at=[0.25, 2])
    assert run.outcome is polhode.Outcome.NON_FINITE
    assert "events that stay finite" in run.advice
    assert abs(float(run.reached) - pole) < 1e-12
    assert run.times == (0.25,)  # what lay before it is kept
    assert min(polhode.compare(run).digits) > 14


def test_an_event_that_stays_finite_is_followed_past_what_looks_like_a_pole():
    run = polhode.integrate(with_event("1/(p - 1) + 2"), at=[5])  # p < 1/2
    assert run.outcome.done
    assert run.events[0].times == ()


@pytest.mark.parametrize("steps", [1, 2, 10])
def test_a_limit_on_steps_is_one(steps):
    """What was left of it reached 0, which to heyoka is no limit."""
    found = polhode.lyapunov("top.toml", 1, max_steps=steps)
    assert abs(found.end) < 1


def test_a_limit_beyond_counting_is_none():
    """It gave heyoka's own TypeError."""
    assert polhode.lyapunov("top.toml", 1, max_steps=10**450).end == 1
    many = polhode.integrate_many("top.toml", {"start.omega[3]": [1]}, at=[1], max_steps=10**450)
    assert many.done


@pytest.mark.parametrize("digits", [0, -1, 1.5, True, "10", None, 10**6])
def test_digits_are_a_whole_number_within_bounds(digits):
    general = polhode.load("general/asymmetric-regular")
    for scene, most in (
        (polhode.load("top.toml"), 5000),
        (general, 250),
    ):
        expected = rf"digits.*: expected a whole number, 1 to {most}"
        with pytest.raises(polhode.BadInput, match=expected):
            polhode.reference(scene).at([1], digits=digits)


@pytest.mark.parametrize("option", ["--at", "--tol", "--number", "-o"])
def test_an_option_without_its_value_is_refused(option):
    """``--at --`` gave an AttributeError."""
    assert promise.of_command(["run", "top.toml", option, "--"]) == ([], 2)
    assert promise.of_command(["run", "top.toml", option]) == ([], 2)


@pytest.mark.parametrize("digits", [1, 5, 15])
def test_mp_of_few_digits_is_run_with_as_many_bits_as_it_takes(digits):
    """heyoka's ValueError came through below 64 bits."""
    run = polhode.integrate("top.toml", "mp", digits=digits, at=[1])
    assert run.outcome.done
    assert run.number.bits >= 64
    assert min(polhode.compare(run).digits) >= digits


def test_digits_without_a_number_are_refused():
    """They were ignored without a word."""
    assert promise.of_command(["compare", "table.csv", "top.toml", "--digits", "30"]) == ([], 2)


def test_one_long_cell_costs_no_reference_of_as_many_digits(monkeypatch):
    asked = []
    exact = polhode.reference("top.toml")
    at = exact.at
    monkeypatch.setattr(exact, "at", lambda t, digits: asked.append(digits) or at(t, digits))
    Path("long.csv").write_text(f"t,p\n0,0.3\n1,0.{'3' * 3000}\n")
    found = polhode.compare("long.csv", exact)
    assert found.worst < 2
    assert max(asked) == 100
    assert found.digits[0] == 1000  # the start is exact, and known as such


def test_a_table_of_many_right_digits_is_given_them_all():
    from polhode.numbers.mpmath_context import mpmath

    exact = polhode.reference("top.toml")
    Path("right.csv").write_text(f"t,p\n1,{mpmath.nstr(exact.at([1], 420)[0][0], 410)}\n")
    assert 405 < polhode.compare("right.csv", exact).worst < 413


def test_an_event_of_an_unknown_direction_is_refused():
    """It was never met, without a word."""
    with pytest.raises(polhode.BadInput, match=r"events\[1\].direction = up: expected rising"):
        polhode.integrate(
            polhode.Scene(
                polhode.load("top.toml").body,
                (1, 2, 3),
                (0, 0, 1),
                times=(1,),
                events=(polhode.Event("x", "p", "up"),),
            )
        )


def test_a_drift_beyond_doubles_is_said_in_words():
    Path("huge.csv").write_text("t,p,q,r,gamma1,gamma2,gamma3\n1,1e400,0,0,0,0,1\n")
    assert "drift h over 1.8e+308" in str(polhode.compare("huge.csv", "top.toml"))


# -- files, folders and interruptions -------------------------------------------------------------


@pytest.mark.parametrize("verb", [["report"], ["study", "events"]])
def test_no_name_is_no_folder(verb):
    """It meant the current one."""
    assert promise.of_command([*verb, "-o", ""]) == ([], 2)


def test_ctrl_c_waits_until_files_are_whole(monkeypatch):
    replaced = os.replace

    def interrupted(*names):
        if str(names[1]).endswith("a.csv"):
            os.kill(os.getpid(), signal.SIGINT)
        replaced(*names)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        files.write_whole({Path("a.csv"): "1", Path("b.json"): "2"})
    assert (Path("a.csv").read_text(), Path("b.json").read_text()) == ("1", "2")
    assert not [*Path().glob(".*")]


def test_ctrl_c_while_a_sweep_is_read_out_loses_nothing(monkeypatch):
    read = results.Reader.states

    def interrupted(*given):
        monkeypatch.setattr(results.Reader, "states", read)
        os.kill(os.getpid(), signal.SIGINT)
        return read(*given)

    monkeypatch.setattr(results.Reader, "states", interrupted)
    many = polhode.integrate_many("top.toml", {"start.omega[1]": [1, "1.1"]}, at=[0])
    assert many.done


@pytest.mark.skipif(sys.platform != "linux", reason="the system's own signal at a parent's end")
def test_a_worker_ends_with_what_started_it():
    worker = "from polhode.peers.protocol import end_with_parent as e; e(); import time; "
    worker += "print(1, flush=True); time.sleep(60)"
    parent = f"import subprocess, sys; p = subprocess.Popen([sys.executable, '-c', {worker!r}], "
    parent += "stdout=subprocess.PIPE); p.stdout.readline(); print(p.pid, flush=True); p.wait()"
    started = subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE)
    pid = int(started.stdout.readline())
    started.kill()
    started.wait()
    started.stdout.close()
    for _ in range(100):
        if not Path(f"/proc/{pid}").exists() or "\nState:\tZ" in _status(pid):
            return
        time.sleep(0.1)
    os.kill(pid, signal.SIGKILL)
    pytest.fail("the worker lived on")


def _status(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return "\nState:\tZ"


@pytest.mark.slow
def test_sigterm_ends_a_run_as_ctrl_c_does():
    command = [sys.executable, "-c", STEPPING, "run", "top.toml", "--max-steps", "10000000000"]
    with subprocess.Popen(
        [*command, "--at", "1e9", "-o", "x.csv"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stdout.readline() == "steps\n"
        run.terminate()
        told = run.stderr.read()
    assert run.returncode == 130
    assert "interrupted" in told
    assert not Path("x.csv").exists()
