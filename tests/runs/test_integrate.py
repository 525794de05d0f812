"""Integration: what enters heyoka, how a run ends, what is refused, what the next run finds."""

import gc
import os
import pickle
import signal
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import heyoka as hy
import numpy as np
import pytest

import polhode
from polhode import Outcome
from polhode.cli import main
from shared.motions import heavy, heavy_file, in_other_units, same_bits, scene_of
from shared.tools import DOUBLE, change_policy, press_ctrl_c

LONG = "euler/largest-axis"


@pytest.mark.parametrize("number", ["double", "extended"])
def test_chunks_take_the_same_steps_bit_for_bit(number, monkeypatch):
    """A run is cut into chunks so that Ctrl-C is heard; the steps are those of an uncut run."""
    whole = polhode.integrate(LONG, number, at=[1000], project=False)
    change_policy(monkeypatch, chunk=7)
    cut = polhode.integrate(LONG, number, at=[1000], project=False)
    assert cut.steps == whole.steps
    # the last step alone is clamped to a rounded time
    assert np.abs(cut.states - whole.states).max() <= 4 * float(whole.number.eps)


@pytest.mark.usefixtures("compiled_as_for_users")
def test_the_states_are_those_of_the_bare_integrator_bit_for_bit():
    """The same equations in bare heyoka, coefficients as parameters, give the same doubles."""
    p, q, r, g1, g2, g3 = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    bare = hy.taylor_adaptive(
        [
            (p, hy.par[0] * (q * r)),
            (q, hy.par[1] * (r * p)),
            (r, hy.par[2] * (p * q)),
            (g1, r * g2 - q * g3),
            (g2, p * g3 - r * g1),
            (g3, q * g1 - p * g2),
        ],
        [0.3, 0.4, 1.1, 2 / 7, 3 / 7, 6 / 7],
        pars=[-0.5, 2 / 3, -0.25],
    )
    top = scene_of(heavy_file("1000", samples=11, weight="0"))
    ours, theirs = (
        polhode.integrate(top, project=False),
        bare.propagate_grid(np.linspace(0, 1000, 11)),
    )
    assert theirs[3] == ours.steps
    assert np.array_equal(theirs[-1], ours.states)


@pytest.mark.parametrize(
    ("number", "exponent"),
    [("double", -40), ("double", 60), ("extended", -7), ("extended", 60), ("quad", 3)],
)
def test_scaling_a_scene_by_powers_of_two_changes_no_bit(number, exponent):
    """Mass, length and time times powers of two, weight to match: the same bits, shifted."""
    scenes = heavy("1"), in_other_units(heavy("1"), exponent)
    first, second = (polhode.integrate(s, number, method="taylor") for s in scenes)
    assert same_bits(first, second, exponent)


# -- dense output of runs of every kind -----------------------------------------------------------

TURNED = {
    "inertia": [["3", "1/2", "1/10"], ["1/2", "5/2", 0], ["1/10", 0, 4]],
    **{"centre": ["3/10", "1/5", "1/2"], "weight": 1, "omega": [300, 400, 1100]},
    **{"gamma": ["2/7", "3/7", "6/7"], "end": "1/50", "samples": 3, "outputs": ["angles"]},
}
STOPPING = '[[events]]\nname = "side"\nzero = "gamma2"\nstop = true\n'
POLE = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1, "gamma": [0, 0, 1], "psi": 20}


@pytest.mark.parametrize(
    ("case", "options"),
    [
        pytest.param(polhode.top(**TURNED), {}, marks=pytest.mark.slow, id="turned, fast"),
        pytest.param(heavy("50", "1.1", STOPPING), {}, id="stopped"),
        pytest.param(heavy("2000"), {"max_steps": 400}, id="step limit"),
        pytest.param(
            polhode.load("lagrange/nutation").at([0, 120]), {"project": 3}, id="projected"
        ),
        pytest.param(polhode.load("kovalevskaya/generic").at([0, 40]), {"tol": "1/10"}, id="loose"),
        pytest.param(polhode.load("lagrange/nutation").at([0]), {}, id="only t = 0"),
        pytest.param(
            polhode.top(**POLE, omega=["0.3", "0.1", 2], end=5, samples=11, outputs=["angles"]),
            {},
            id="from a pole",
        ),
    ],
)
def test_the_state_at_any_time_is_that_of_the_run(case, options, monkeypatch):
    """In any order, across many chunks and corrections, and no further than the run came."""
    change_policy(monkeypatch, chunk=20)
    run = polhode.integrate(case, **options)
    near = 32 * 2.0**-52 * max(1, np.abs(run.states).max())
    end = run.reached
    between = [end * Fraction(k, 7) for k in (2, 5, 6)]
    apart = [run(t) for t in reversed(between)][::-1]
    for k in reversed(range(len(run.times))):
        assert (run(run.times[k]) == run.states[k]).all()
    again = pickle.loads(pickle.dumps(run))
    with ThreadPoolExecutor(4) as pool:
        for state in (run(between), again(between), [*pool.map(again, between)]):
            assert (np.array(state) == np.array(apart)).all()
    third = DOUBLE.rounded(end / 3)
    middle = polhode.integrate(case, at=[third, case.end or 1], **options).states[0]
    assert np.abs(run(third) - middle).max() <= near / 16  # by the steps of the run itself
    for event in run.events:
        assert np.abs(run(event.times[0]) - event.states[0]).max() <= near
    with pytest.raises(polhode.BadInput):
        run(end + Fraction(1, 10**6))
    if "attitude" in case.outputs:
        assert (run.attitude_at(run.times[-1]) == run.attitude[-1]).all()
    if "angles" in case.outputs and end:
        for t in (end / 1000, end / 3):  # the first is next to a start at a pole
            beside = polhode.integrate(case, at=[t, case.end], **options).angles[0]
            assert max(abs(x - y) for x, y in zip(run.angles_at(t), beside, strict=True)) <= near
    with pytest.raises(ValueError, match="output times only"):
        replace(run, dense=None)(end)


@pytest.mark.slow
def test_a_time_is_not_rounded():
    """Near t = 2e4 a double's last bit is 3.6e-12; the state still tells an eighth of it apart."""
    run = polhode.integrate(heavy("20000", "3"))
    t, by = Fraction(19_999) + Fraction(1, 7), Fraction(1, 2**41)
    here, there = run(t), run(t + by)
    middle = (run(t + 2**10 * by) - here) / 2**10  # the rate, nearly
    assert np.abs(there - here).max() > 2.5e-13
    assert np.abs(there - here - middle).max() < 4e-15


def test_a_time_that_the_type_does_not_hold_is_refused():
    run = polhode.integrate(heavy("1", "2"))
    with pytest.raises(polhode.BadInput, match=r"t = 1\.0+e-400: expected a time that do"):
        run("1e-400")


def test_output_times_far_out_are_counted_from_the_exact_time():
    """On a grid that no double holds, rounded once: as good as at times that are alone."""
    grid = [Fraction(500) + Fraction(k, 7000) for k in range(2000)]
    run = polhode.integrate(LONG, at=grid)
    for k in (1, 777, 1999):
        alone = polhode.integrate(LONG, at=[grid[k], 501]).states[0]
        assert np.abs(run.states[k] - alone).max() < 8 * 2.0**-52


# -- outcomes -------------------------------------------------------------------------------------


def test_every_outcome_has_a_cause_and_every_failure_advice():
    for outcome in Outcome:
        assert outcome.cause
        assert outcome.done or outcome.advice


@pytest.mark.parametrize(
    ("options", "steps"), [({"max_steps": 50}, 50), ({"at": [Fraction(10) ** 30]}, 10**7)]
)
def test_a_step_limit_is_an_outcome_with_advice(options, steps):
    """An end that cannot be reached is seen at once: a hang would take hours."""
    began = time.process_time()
    run = polhode.integrate(LONG, **options)
    assert run.outcome is Outcome.STEP_LIMIT
    assert not run.outcome.done
    assert run.steps <= steps
    assert run.reached >= 0
    assert len(run.times) == len(run.states) < len(run.scene.times)
    assert "--max-steps" in run.outcome.advice
    assert time.process_time() - began < 20


def test_a_state_that_becomes_infinite_is_an_outcome(monkeypatch):
    scene = polhode.load("euler/attitude")  # starts at a pole, where psi' is 0/0
    monkeypatch.setattr(polhode.Scene, "starts_at_pole", False)  # and is led over it otherwise
    run = polhode.integrate(replace(scene, outputs=("angles",)), at=[1])
    assert run.outcome is Outcome.NON_FINITE
    assert "angles" in run.outcome.advice


@pytest.mark.parametrize("number", ["double", "quad"])
def test_ctrl_c_ends_a_run_within_a_second_and_reports_what_was_reached(number):
    sent: list[float] = []

    def press() -> None:
        sent.append(time.process_time())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.2, press)

    def note(fraction: float, count: int) -> None:
        if fraction > 0 and timer.ident is None:  # a loaded machine may take long to begin
            timer.start()

    times = [Fraction(k) for k in range(100, 40_000_000, 100_000)]
    run = polhode.integrate(LONG, number, at=times, max_steps=10**9, progress=note)
    ended = time.process_time()
    timer.join()
    assert run.outcome is Outcome.INTERRUPTED
    assert run.reached > 0
    assert len(run.times) == len(run.states) < len(times)
    assert all(t <= run.reached for t in run.times)
    assert ended - sent[0] < 5  # of processor time; the whole run would take minutes


def test_ctrl_c_of_a_command_exits_130_and_writes_what_there_is(tmp_path, monkeypatch, capsys):
    path = tmp_path / "x.csv"
    press_ctrl_c(monkeypatch, 1)
    command = ["run", LONG, "--at", "100,1e10", "--max-steps", "1000000000000"]
    assert main([*command, "-o", str(path)]) == 130
    assert "interrupted" in capsys.readouterr().err
    again = polhode.load_run(path)
    assert (again.outcome, again.times) == (Outcome.INTERRUPTED, (100,))


# -- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{}, {"method": "taylor"}, {"number": "quad"}])
@pytest.mark.parametrize(
    ("key", "value"), [("project", 0), ("project", -3), ("max_steps", 0), ("tol", 1), ("tol", 0)]
)
def test_options_are_checked_whatever_becomes_of_them(options, key, value):
    with pytest.raises(polhode.BadInput, match=f" {key} = {value}: "):
        polhode.integrate(LONG, at=[1], **options, **{key: value})


def test_a_tolerance_below_eps_is_refused_and_a_loose_one_costs_digits():
    with pytest.raises(polhode.BadInput, match="eps"):
        polhode.integrate(LONG, tol=1e-17)
    assert polhode.integrate(LONG, at=[1], tol=0.1).outcome.done  # the most, though no tenth
    loose = polhode.integrate(LONG, at=[10], tol="1e-8")
    assert 6 < polhode.compare(loose).worst < 11
    assert not loose.at_full_tolerance


# -- what is kept for the next run ----------------------------------------------------------------


@pytest.mark.slow
def test_nothing_that_is_kept_is_part_of_a_scene_or_outlives_it():
    keys = {"moments": [3, 2, 1], "omega": [1, 2, 3], "gamma": [0, 0, 1], "end": 50}
    event = polhode.Event("q", "q - 1/9")
    scene, twin = (polhode.top(**keys, events=[event]) for _ in "ab")
    run = polhode.integrate(scene)
    assert scene == twin
    assert "identity" not in vars(pickle.loads(pickle.dumps(scene)))
    assert polhode.integrate(scene) == polhode.integrate(twin) == run
    gone = weakref.ref(scene.identity)
    del scene
    gc.collect()
    assert gone() is not None  # the run can be asked for other times
    del run
    gc.collect()
    assert gone() is None
