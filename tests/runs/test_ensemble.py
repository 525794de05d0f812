"""Many tops at once: every member is its own run, whoever carries it out."""

from __future__ import annotations

import os
import signal
import threading
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from fractions import Fraction
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode.common import memory
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import exactly
from polhode.runs.sweep import plan as sweep_plan
from polhode.runs.sweep import results
from polhode.scenes import scene_file
from polhode.scenes.variation import vary
from polhode.taylor.batches import batch_integrator
from shared.examples import examples
from shared.motions import heavy, heavy_file
from shared.policies import change_policy

NUMBERS = ("double", "extended", "quad", "mp")


def ulps(a, b, number) -> float:
    """The largest difference between tables of states, in the type's eps."""
    pairs = ((x, y) for p, q in zip(a, b, strict=True) for x, y in zip(p, q, strict=True))
    return max(float(abs(exactly(x) - exactly(y)) / number.eps) for x, y in pairs)


# -- each member is its own run -------------------------------------------------------------------


@pytest.mark.sample(1, slow=3)
@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("end", ["9", "-9"])
def test_members_are_the_runs_of_their_scenes(number, end):
    """Coefficients as parameters, lanes side by side: within rounding of one run after another.

    Two starts that differ by one rounding part by some tens of eps on these motions; steps made
    of the same code differ by less.  Bodies in which other coefficients vanish are among them.
    """
    scene = heavy(end)
    many = polhode.integrate_many(
        scene,
        {"start.omega[3]": ["0.5", 3], "body.weight": [0, 1], "body.moments[2]": [3, 4]},
        number=number,
        method="taylor",
    )
    assert many.done
    assert len(many) == 8
    assert many.states.shape == (8, 5, 6)
    for member in many:
        single = polhode.integrate(member.scene, member.number, method="taylor")
        assert member.times == single.times
        assert ulps(member.states, single.states, single.number) < 128
        assert abs(member.steps - single.steps) <= 5


def test_members_are_as_right_as_their_closed_forms_say():
    """A Lagrange top spun at sixteen speeds: digits of every member by its closed form."""
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [2, 2, 1]\ncentre = [0, 0, 1]\nweight = 1\n[start]\n"
        'omega = [0.3, 0.1, 2]\ngamma = ["3/5", 0, "4/5"]\n[run]\nend = 50\nsamples = 3\n'
    )
    many = polhode.integrate_many(scene, {"start.omega[3]": "0.5:8:16"})
    for member in many:
        judged = polhode.compare(member, polhode.reference(member.scene))
        single = polhode.compare(polhode.integrate(member.scene), polhode.reference(member.scene))
        assert 12.3 < judged.worst < 16
        assert abs(judged.worst - single.worst) < 1.3


@pytest.mark.slow
def test_units_and_turned_axes_of_each_member():
    """Members with their own principal axes and units of time, states in the scene's axes."""
    scene = scene_file.parse(
        "schema = 1\n[body]\ninertia = [[3, 0.5, 0.1], [0.5, 2.5, 0], [0.1, 0, 4]]\n"
        "centre = [0.3, 0.2, 0.5]\nweight = 1\n[start]\nomega = [0.3, 0.4, 1.1]\n"
        'gamma = ["2/7", "3/7", "6/7"]\n[run]\nat = [0.01, 2, 3]\n'
    )
    many = polhode.integrate_many(
        scene, {"start.omega[1]": [1, 100], "body.inertia[1][2]": ["0.5", 0]}
    )
    assert len({member.time_unit for member in many.members}) == 2
    assert many.members[1].body.inertia[1][0] == 0
    for member in many:
        single = polhode.integrate(member.scene)
        scale = 100 if member.scene.omega[0] == 100 else 1
        assert ulps(member.states, single.states, single.number) < 400 * scale


def test_a_free_body_without_gamma():
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [1, 2, 3]\n[start]\nomega = [0.1, 1, 0]\n[run]\nend = 9\n"
    )
    many = polhode.integrate_many(scene, {"start.omega[1]": [0, "0.1"]})
    assert many.columns == ("p", "q", "r")
    for member in many:
        single = polhode.integrate(member.scene)
        assert ulps(member.states, single.states, single.number) < 16


@settings(deadline=None, max_examples=examples(10))
@given(
    st.lists(st.fractions(-3, 3, max_denominator=99), min_size=1, max_size=19),
    st.integers(1, 5),
)
def test_order_and_number_of_members_change_no_bit(spins, workers):
    """A member's digits depend neither on its neighbours in a batch nor on the threads."""
    scene = heavy("7")
    many = polhode.integrate_many(scene, {"start.omega[3]": spins}, workers=workers)
    back = polhode.integrate_many(scene, {"start.omega[3]": spins[::-1]})
    assert np.array_equal(many.states, back.states[::-1])
    assert [row[0] for row in many.varied.rows] == spins


def test_chunks_change_little(monkeypatch):
    whole = polhode.integrate_many(heavy(), {"start.omega[3]": "0.5:1.5:9"})
    change_policy(monkeypatch, chunk=12)
    cut = polhode.integrate_many(heavy(), {"start.omega[3]": "0.5:1.5:9"})
    assert np.abs(whole.states - cut.states).max() < 128 * 2.0**-52


def test_only_t_0():
    many = polhode.integrate_many(heavy(), {"start.omega[3]": [1, 2]}, at=[0])
    assert many.states.shape == (2, 1, 6)
    assert list(many.states[:, 0, 2]) == [1, 2]


# -- what is varied -------------------------------------------------------------------------------


def test_values_are_exact_and_evenly_spaced():
    many = polhode.integrate_many(heavy(), {"start.omega[1]": "0.1:0.4:4"}, at=[1])
    assert [row[0] for row in many.varied.rows] == [Fraction(k, 10) for k in (1, 2, 3, 4)]
    assert [m.omega[0] for m in many.members] == [Fraction(k, 10) for k in (1, 2, 3, 4)]
    assert many.members[0].source == ""
    assert many.members[0].text != many.members[1].text


def test_members_one_by_one():
    given = [{"start.omega[1]": k, "body.weight": 2 - k} for k in (0, 1, 2)]
    many = polhode.integrate_many(heavy(), given, at=[1])
    assert [(m.omega[0], m.body.weight) for m in many.members] == [(0, 2), (1, 1), (2, 0)]


def test_a_normalised_vertical_may_be_varied():
    scene = scene_file.parse(heavy_file("1").replace("[run]", "normalise = true\n[run]"))
    many = polhode.integrate_many(scene, {"start.gamma[1]": [0, 1, "sqrt(2)"]})
    assert np.allclose((many.states[:, 0, 3:] ** 2).sum(axis=1), 1, rtol=4e-16, atol=0)


def test_angles_may_be_varied():
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [2, 2, 1]\ncentre = [0, 0, 1]\nweight = 1\n[start]\n"
        'angles = [0, "pi/3", 0]\nrates = [0, 0, 5]\n[run]\nend = 1\n'
    )
    many = polhode.integrate_many(scene, {"start.angles[2]": ["pi/3", "pi/2"]})
    assert np.allclose(many.states[:, 0, 5], [0.5, 0], rtol=0, atol=1e-16)


def test_a_scene_made_in_python_may_be_varied():
    scene = polhode.Scene(
        polhode.Body.of_moments((2, 3, 4), (0.5, 0, 0), 1), (1, 0, 0), (1, 0, 0), times=(1,)
    )
    many = polhode.integrate_many(scene, {"body.moments[3]": [4, 4.5], "start.omega[2]": [0, 1]})
    assert [m.body.moments[2] for m in many.members] == [4, 4, 4.5, 4.5]


def test_a_scene_changed_in_python_is_varied_as_it_is():
    from dataclasses import replace

    scene = replace(heavy(), omega=(9, 9, 9))
    many = polhode.integrate_many(scene, {"start.omega[1]": [1]}, at=[1])
    assert many.members[0].omega == (1, 9, 9)
    assert many.members[0].gamma == scene.gamma


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "vary: expected at least one number of the scene file to vary"),
        ({"start.omga[1]": [1]}, r"vary = start.omga\[1\]: .*did you mean 'start.omega\[1\]'"),
        ({"start.omega[4]": [1]}, r"vary = start.omega\[4\]: expected a number of the scene"),
        ({"run.end": [1]}, "vary = run.end: expected a number of the scene"),
        ({"start.omega[1]": []}, r"start.omega\[1\] = nothing: expected at least one value"),
        ({"start.omega[1]": 1}, r"start.omega\[1\] = 1: expected a sequence of numbers"),
        ({"start.omega[1]": "1:2:0"}, "expected FROM:TO:N with N from 1 to 10000000$"),
        ({"start.omega[1]": "1:2:-3"}, "expected FROM:TO:N with N"),
        ({"start.omega[1]": "1:2:2.5"}, "expected FROM:TO:N with N"),
        ({"start.omega[1]": "1:2"}, "expected FROM:TO:N"),
        ({"start.omega[1]": "1:x:3"}, "expected numbers"),
        ({"start.omega[1]": [float("nan")]}, "= nan: expected a number"),
        (
            {"start.omega[1]": "0:1:10000", "start.omega[2]": "0:1:1001"},
            "10010000 members: .*10000000;",
        ),
        (
            {"body.moments[3]": [5, 6]},
            r"member 2 \(body.moments\[3\] = 6\): body.moments = \[2, 3, 6\]: expected principal",
        ),
        ({"start.gamma[1]": [0]}, r"member 1 .*: expected length exactly 1, or normalise = true"),
        ([{"body.weight": 1}, {"start.psi": 1}], "member 2 = start.psi: expected the keys body.w"),
        ({"start.omega[1]": [1, "1e400"]}, r"member 2 .*: number = double: expected a type of wi"),
    ],
)
def test_what_cannot_be_varied_is_refused_in_one_line(given, message):
    with pytest.raises(polhode.BadInput, match=message) as fault:
        polhode.integrate_many(heavy(), given)
    assert "\n" not in str(fault.value)


def test_both_halves_of_a_symmetric_inertia_are_one_number():
    scene = scene_file.parse(
        "schema = 1\n[body]\ninertia = [[3, 0.5, 0], [0.5, 2.5, 0], [0, 0, 4]]\n[start]\n"
        "omega = [1, 0, 0]\n[run]\nend = 1\n"
    )
    both = {"body.inertia[1][2]": [0], "body.inertia[2][1]": [1]}
    with pytest.raises(polhode.BadInput, match="they are one number"):
        polhode.integrate_many(scene, both)


def test_events_are_refused():
    scene = scene_file.parse(heavy_file("1") + '[[events]]\nname = "equator"\n')
    with pytest.raises(polhode.BadInput, match="events = equator: expected none in a sweep"):
        polhode.integrate_many(scene, {"body.weight": [1]})


def test_too_many_numbers_are_refused(monkeypatch):
    monkeypatch.setattr(sweep_plan, "_BYTES", memory.MOST_BYTES // 100)
    with pytest.raises(polhode.BadInput, match="4 members at 5 times: expected at most 100"):
        polhode.integrate_many(heavy(), {"body.weight": "0:1:4"})


# -- how it ends ----------------------------------------------------------------------------------


def test_a_member_that_fails_carries_its_outcome_and_harms_no_neighbour():
    given = {"body.weight": [1, "1e6", 2, 3]}
    many = polhode.integrate_many(heavy(), given, max_steps=400)
    ended = [Outcome.REACHED_END, Outcome.STEP_LIMIT, Outcome.REACHED_END, Outcome.REACHED_END]
    assert list(many.outcomes) == ended
    assert not many.done
    assert not many.interrupted
    free = polhode.integrate_many(heavy(), {"body.weight": [1, 2, 3]})
    assert np.array_equal(many.states[[0, 2, 3]], free.states)
    assert np.isnan(many.states[1, 1:]).all()
    assert many[1].times == (0,)
    assert many[1].reached < 20


def test_a_hopeless_end_is_an_outcome_not_a_hang():
    many = polhode.integrate_many(heavy("1e30"), {"body.weight": [1, 2]}, number="double")
    assert set(many.outcomes) == {Outcome.STEP_LIMIT}


def test_the_outcome_of_a_single_run_with_the_same_limit():
    for limit in (50, 400):
        many = polhode.integrate_many(heavy("60"), {"body.weight": [1]}, max_steps=limit)
        single = polhode.integrate(many[0].scene, max_steps=limit)
        assert many.outcomes[0] is single.outcome
        assert len(many[0].times) == len(single.times)


@pytest.mark.parametrize("number", ["double", "quad"])
def test_ctrl_c_keeps_what_is_finished(number):
    """The keyboard interrupts after the fifth job: its members stay, the rest are marked."""
    seen = []

    def progress(fraction, done):
        seen.append((fraction, done))
        if len(seen) == 5:
            signal.raise_signal(signal.SIGINT)

    given = {"start.omega[3]": "0.5:9:400"}
    end = "1000" if number == "double" else "20"
    many = polhode.integrate_many(heavy(end), given, number=number, progress=progress, workers=2)
    assert many.interrupted
    assert not many.done
    finished = [k for k, outcome in enumerate(many.outcomes) if outcome.done]
    assert seen[4][1] <= len(finished) < 400
    k = finished[0]
    single = polhode.integrate(many[k].scene, number)
    assert ulps(many[k].states[:2], single.states[:2], single.number) < 2**30
    undone = many.outcomes.index(Outcome.NOT_RUN)
    assert many[undone].times == ()
    assert many.steps[undone] == 0
    assert np.isnan(many.drift[undone]).all()


def test_progress_counts_members():
    seen = []
    polhode.integrate_many(
        heavy(), {"body.weight": "0:1:20"}, progress=lambda *told: seen.append(told)
    )
    assert seen[-1] == (1, 20)
    assert [done for _, done in seen] == sorted(done for _, done in seen)


def test_the_work_is_shared_among_threads(monkeypatch):
    by = set()
    together = threading.Barrier(2, timeout=20)
    solve = batch_integrator.solve

    def noted(job, stop):
        if threading.get_ident() not in by:
            by.add(threading.get_ident())
            together.wait()
        return solve(job, stop)

    monkeypatch.setattr(batch_integrator, "solve", noted)
    polhode.integrate_many(heavy(), {"body.weight": "0:1:64"}, workers=2)
    assert len(by) == 2
    assert threading.get_ident() not in by


def test_bare_steps_are_said_to_be_bare():
    many = polhode.integrate_many(heavy(), {"body.weight": [1]}, at=[1])
    assert many.projected is False
    told = " ".join(polhode.integrate_many.__doc__.split())
    assert "States are *not* projected" in told
    assert "digits are *not* checked" in told


# -- executors ------------------------------------------------------------------------------------

GIVEN = {"start.omega[3]": "0.5:1.5:40", "body.weight": [0, 1]}


def spawned() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(2, mp_context=get_context("spawn"))


@pytest.mark.slow
def test_a_process_pool_gives_the_same_bits():
    here = polhode.integrate_many(heavy(), GIVEN)
    with warnings.catch_warnings(), spawned() as pool:
        warnings.simplefilter("error")
        there = polhode.integrate_many(heavy(), GIVEN, executor=pool)
        wide = polhode.integrate_many(heavy("2"), {"body.weight": [1]}, number="mp", executor=pool)
    assert np.array_equal(here.states, there.states)
    assert here.steps == there.steps
    assert ulps(wide[0].states, polhode.integrate(wide[0].scene, "mp").states, wide.number) < 16


def die_once(mark, solve, job):
    """Take the worker's process down with the first job that is tried."""
    if not Path(mark).exists():
        Path(mark).touch()
        os._exit(1)
    return solve(job)


class Deadly(Executor):
    """An executor one of whose workers dies."""

    def __init__(self, pool: Executor, mark: Path) -> None:
        self.pool, self.mark = pool, str(mark)

    def submit(self, fn, /, *args, **kwargs):
        return self.pool.submit(die_once, self.mark, fn, *args, **kwargs)


@pytest.mark.slow
def test_a_worker_that_dies_costs_no_result(tmp_path):
    here = polhode.integrate_many(heavy(), GIVEN)
    with spawned() as pool:
        deadly = Deadly(pool, tmp_path / "died")
        with pytest.warns(RuntimeWarning, match=r"of 11 jobs were lost \(BrokenProcessPool"):
            there = polhode.integrate_many(heavy(), GIVEN, executor=deadly)
    assert (tmp_path / "died").exists()
    assert there.done
    assert np.array_equal(here.states, there.states)


def test_an_executor_that_is_shut_down_costs_no_result():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.warns(RuntimeWarning, match="1 of 1 jobs were lost"):
        many = polhode.integrate_many(heavy(), {"body.weight": [1]}, executor=pool)
    assert many.done


def test_a_fault_of_ours_is_not_hidden(monkeypatch):
    def broken(job, stop=None):
        raise ZeroDivisionError("ours")

    monkeypatch.setattr(batch_integrator, "solve", broken)
    with pytest.raises(ZeroDivisionError):
        polhode.integrate_many(heavy(), {"body.weight": [1]})


def test_ctrl_c_with_an_executor_keeps_what_is_finished():
    seen = []

    def progress(fraction, done):
        seen.append(done)
        if len(seen) == 3:
            signal.raise_signal(signal.SIGINT)

    with ThreadPoolExecutor(1) as pool:
        many = polhode.integrate_many(
            heavy("200"), {"start.omega[3]": "0.5:9:200"}, executor=pool, progress=progress
        )
    assert many.interrupted
    assert sum(outcome.done for outcome in many.outcomes) == seen[-1]


def test_a_job_is_plain_data():
    import pickle

    plan = sweep_plan.planned(heavy(), {"body.weight": ["sqrt(2)"]}, None, None, None, None)
    for table in plan.lanes:
        assert table.dtype == np.float64
        assert np.array_equal(pickle.loads(pickle.dumps(table)), table)
    assert plan.lanes.coefficients[0, 0] == pytest.approx(float(np.sqrt(2)) / 4, rel=2**-52)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_bits_though_a_worker_dies(tmp_path):
    distributed = pytest.importorskip("dask.distributed")
    here = polhode.integrate_many(heavy(), GIVEN)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        there = polhode.integrate_many(heavy(), GIVEN, executor=client.get_executor())
        assert np.array_equal(here.states, there.states)
        deadly = Deadly(client.get_executor(), tmp_path / "died")
        again = polhode.integrate_many(heavy(), GIVEN, executor=deadly)
    assert (tmp_path / "died").exists()
    assert again.done
    assert np.array_equal(here.states, again.states)


def test_the_grid_s_option():
    assert vary.option("body.weight=1/3,sqrt(4)", "x") == ("body.weight", [Fraction(1, 3), 2])
    assert vary.option("a=1:2:1", "x")[1] == [1]


def test_ctrl_c_while_a_finished_member_is_put_away(monkeypatch):
    """It waits: nothing that is finished is lost, and the sweep is interrupted."""
    reader, sent = results.reader, []

    def interrupted(*asked):
        if not sent:
            sent.append(signal.raise_signal(signal.SIGINT))
        return reader(*asked)

    monkeypatch.setattr(results, "reader", interrupted)
    many = polhode.integrate_many(heavy("200"), {"start.omega[3]": "0.5:9:400"}, workers=1)
    assert many.interrupted
    finished = [k for k, outcome in enumerate(many.outcomes) if outcome.done]
    assert finished
    assert np.isfinite(many.states[finished]).all()


def test_iteration_gives_the_members():
    many = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:3"}, at=[0, 1])
    assert isinstance(many, Iterable)
    assert list(many) == [many[0], many[1], many[2]]
