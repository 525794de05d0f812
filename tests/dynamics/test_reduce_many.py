"""Sweeps reduced to numbers: the same as from states and runs that are kept, held by nobody."""

import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode import Outcome
from shared.motions import heavy, scene_of
from shared.tools import tiers

VARIED = {"start.omega[3]": "0.5:4:5", "body.weight": ["1/2", 1, 3]}
EVENTS = (
    polhode.Event("half", "gamma3 - 1/2", "falling"),
    polhode.Event("rises", "p*gamma2 - q*gamma1", "rising"),
    polhode.Event("late", "t*gamma1 - 2"),
    polhode.Event("level", "q - 1/3"),
    polhode.Event("never", "gamma3 - 7"),
)
TURNED = (
    "schema = 1\n[body]\ninertia = [[3, 0.5, 0.1], [0.5, 2.5, 0], [0.1, 0, 4]]\n"
    "centre = [0.3, 0.2, 0.5]\nweight = 1\n[start]\nomega = [0.3, 0.4, 1.1]\n"
    'gamma = ["2/7", "3/7", "6/7"]\n[run]\nend = {end}\nsamples = 9\n'
)
EPS = 2.0**-52


def theta(states):
    return np.arctan2(np.hypot(states[..., 3], states[..., 4]), states[..., 5])


@pytest.mark.parametrize(
    ("number", "turned"),
    tiers([("double", False), ("double", True)], [("extended", False), ("extended", True)]),
)
def test_states_and_extremes_are_those_of_kept_states_to_the_bit(number, turned):
    scene = scene_of(TURNED.format(end=9)) if turned else heavy("9")
    varied = {"start.omega[1]": [1, 100], "body.inertia[1][2]": ["0.5", 0]} if turned else VARIED
    keep = ["final", "largest theta", "smallest p*gamma1 - q/3", "largest sin(t)*r"]
    found = polhode.reduce_many(scene, varied, keep, number=number)
    many = polhode.integrate_many(scene, varied, number=number)
    states, times = many.states, np.array([float(t) for t in many.times], many.states.dtype)
    assert found.complete
    assert np.array_equal(np.array([found[f"final {x}"] for x in many.columns]).T, states[:, -1])
    p, q, r, g = (states[:, :, i] for i in range(4))
    for name, values in (
        ("largest theta", theta(states)),
        ("smallest p*gamma1 - q/3", -(p * g - q / 3)),
        ("largest sin(t)*r", np.sin(times) * r),
    ):
        best, at = values.max(axis=1), values.argmax(axis=1)
        assert np.array_equal(np.abs(found[name]), np.abs(best))
        assert np.array_equal(found[f"t of {name}"], times[at])
        assert found[name].dtype == states.dtype


@pytest.mark.slow
def test_first_events_are_the_first_of_each_run(monkeypatch):
    """Times and states to a few eps (times of a double end at eps t; errors grow with t)."""
    monkeypatch.setattr("polhode.dynamics.reduce_many.STRETCH", 3.0)  # more than one stretch
    events = EVENTS[::2]
    scene = replace(scene_of(TURNED.format(end="-11")), events=events)
    varied = {"start.omega[1]": [1, 20], "body.inertia[1][2]": ["0.5", 0]}
    keep = [f"first {event.name}" for event in events]
    found = polhode.reduce_many(scene, varied, keep)
    many = polhode.integrate_many(replace(scene, events=()), varied)
    seen = set()
    for k in (0, 3):
        member = many.members[k]
        run = polhode.integrate(replace(member, times=scene.times, events=events), project=False)
        fast = max(float(abs(x)) for x in member.omega)
        for event, name in zip(run.events, keep, strict=True):
            t = found[f"t of {name}"][k]
            assert bool(event.times) is not bool(np.isnan(t))
            if event.times:
                seen.add(name)
                assert abs(float(event.times[0]) - t) < 16 * EPS * (1 + abs(t))
                state = np.array([found[f"{x} at {name}"][k] for x in run.columns])
                error = np.abs(state - event.states[0]).max()
                assert error < 400 * EPS * fast * (1 + fast * abs(t))
    assert seen == set(keep[:2])


def test_a_zero_at_the_start_is_no_event():
    scene = replace(heavy("9"), events=(polhode.Event("back", "gamma1 - 2/7"),))
    found = polhode.reduce_many(scene, VARIED, "first back")
    assert (found["t of first back"] > 0.1).sum() == 14
    assert np.isnan(found["t of first back"]).sum() == 1
    member = replace(found.members[14], times=scene.times, events=scene.events)
    (event,) = polhode.integrate(member, project=False).events
    assert abs(float(event.times[0]) - found["t of first back"][14]) < 16 * EPS * 9


@pytest.mark.slow
def test_exponents_are_those_of_lyapunov():
    """Regular motions: two tangents alike part by rounding, which grows as they do."""
    scene = heavy("200")
    found = polhode.reduce_many(scene, {"start.omega[3]": [3, 5, 80]}, "lyapunov")
    assert found.members[0].time_unit != found.members[2].time_unit
    for k in range(3):
        one = polhode.lyapunov(found.members[k], 200)
        assert abs(found["lyapunov"][k] - one.exponent) < 1e-9 * one.uncertainty
        assert found["lyapunov uncertainty"][k] == pytest.approx(one.uncertainty, rel=1e-8)
        assert found["lyapunov growth"][k] == pytest.approx(one.growth, abs=1e-8)


@pytest.mark.parametrize(("case", "end"), [("euler/separatrix", 200), ("staude/unstable", 200)])
def test_exponents_of_known_motions_are_those_of_lyapunov(case, end):
    """They were of the neighbour that doubles follow, once the motion itself is lost."""
    scene = polhode.load(case).at([end])
    found = polhode.reduce_many(scene, {"start.psi": [0]}, "lyapunov")
    one = polhode.lyapunov(scene, end)
    numbers = (one.exponent, one.uncertainty, one.growth)
    assert tuple(found[name][0] for name in found.names) == numbers


def exponents_of_chaotic_members_scatter_as_their_uncertainties_say():
    """By blocks of one motion's time alone they were two thirds of it, and most of them less."""
    scene = polhode.load("general/asymmetric-chaotic").at([2000])
    found = polhode.reduce_many(scene, {"start.omega[1]": "0.2:0.21:80"}, "lyapunov")
    told = np.sqrt(np.mean(found["lyapunov uncertainty"] ** 2))
    assert 0.7 < told / np.std(found["lyapunov"], ddof=1) < 1.4
    one = polhode.lyapunov(scene, 3000)
    assert one.verdict == "chaotic"
    assert abs(np.median(found["lyapunov"]) - one.exponent) < 4 * one.uncertainty
    assert (found["lyapunov growth"] > 6).all()


@pytest.mark.slow
def test_the_uncertainty_of_a_chaotic_member_is_its_neighbours_scatter(monkeypatch):
    """Where they are the member itself, it is 0."""
    monkeypatch.setattr("polhode.dynamics.lyapunov.MOVED", (1.0,) * 7)
    scene = polhode.load("general/asymmetric-chaotic").at([600])
    found = polhode.reduce_many(scene, {"start.omega[1]": "0.2,0.25,30"}, "lyapunov")
    told = found["lyapunov uncertainty"]
    assert (told[:2] == 0).all()
    assert told[2] > 0  # a fast top, which is regular


@pytest.mark.slow
def test_a_member_that_fails_has_no_numbers_and_harms_no_neighbour():
    scene = replace(heavy("9"), events=EVENTS)
    keep = ["final", "first half", "lyapunov"]
    varied = {"body.weight": [1, 10**6]}
    found = polhode.reduce_many(scene, varied, keep, max_steps=300)
    alone = polhode.reduce_many(scene, {"body.weight": [1]}, keep)
    assert found.tally() == {Outcome.REACHED_END: 1, Outcome.STEP_LIMIT: 1}
    assert not found.complete
    for name in found.names:
        assert np.isnan(found[name][1])
        assert found[name][0] == alone[name][0] or np.isnan(alone[name][0])


@pytest.mark.slow
def test_no_more_states_are_held_than_a_job_has(monkeypatch):
    monkeypatch.setattr("polhode.dynamics.reduce_many.MOST_AT_ONCE", 1 << 16)
    scene = heavy("2").at([k / 1000 for k in range(2001)])
    varied = {"start.omega[3]": "1:3:96"}
    polhode.reduce_many(scene, {"start.omega[3]": "1:3:8"}, "largest theta", workers=1)
    tracemalloc.start()
    found = polhode.reduce_many(scene, varied, "largest theta", workers=1)
    held = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.complete
    assert held < 96 * 2001 * 48 / 2  # bytes of all states: 9 MB, of which a job has a third


@pytest.mark.slow
def test_what_was_interrupted_goes_on_to_the_same_bits(tmp_path):
    """Also where no step is counted: with an exponent alone, all finished jobs were lost."""
    scene, keep, many = replace(heavy("9"), events=EVENTS), ["final", "first half"], 800
    varied = {"start.omega[3]": f"1:3:{many}"}
    whole = polhode.reduce_many(scene, varied, keep)

    told = []

    def disturb(fraction, _):
        told.append(fraction)
        if len(told) == 3:
            raise KeyboardInterrupt

    first = polhode.reduce_many(
        scene, varied, keep, workers=1, parts=tmp_path / "p", progress=disturb
    )
    assert first.interrupted
    assert 0 < first.tally()[Outcome.REACHED_END] < many
    done = []
    again = polhode.reduce_many(
        scene, varied, keep, parts=tmp_path / "p", progress=lambda _, n: done.append(n)
    )
    assert again == whole
    assert again.kept is not None
    with pytest.raises(polhode.BadInput, match="the jobs of the same command"):
        polhode.reduce_many(scene, varied, "final", parts=tmp_path / "p")
    again.kept.remove()
    assert not (tmp_path / "p").exists()


@pytest.mark.slow
def test_an_executor_gives_the_same_bits():
    keep = ["final", "first half", "lyapunov", "largest theta"]
    scene = replace(heavy("9"), events=EVENTS)
    with ThreadPoolExecutor(2) as pool:
        found = polhode.reduce_many(scene, VARIED, keep, executor=pool)
    assert found == polhode.reduce_many(scene, VARIED, keep, workers=1)


@pytest.mark.parametrize(
    ("keep", "number", "said"),
    [
        ("greatest theta", None, "final, largest X, smallest X, first EVENT or lyapunov"),
        ("largest", None, "final, largest X"),
        ([], None, "final, largest X"),
        ([3], None, "final, largest X"),
        ("largest psi", None, "unknown name 'psi'"),
        ("smallest 1/0", None, "division by zero"),
        ("first flip", None, "an event with an expression"),
        ("first root", None, "without roots and division"),
        ("first nothing", None, "not zero everywhere"),
        ("first far", None, "a type of wider range (10**-320 is outside the range of double)"),
        ("first halves", None, "did you mean 'half'"),
        ("final", "quad", "double or extended"),
        ("lyapunov", "extended", "double, for lyapunov"),
        ("first half", "extended", "double, for first half"),
    ],
)
def test_what_cannot_be_kept_is_refused_in_one_line(keep, number, said):
    root = polhode.Event("root", "sqrt(gamma3 + 2) - 1")
    nothing = polhode.Event("nothing", "0*gamma3")
    far = polhode.Event("far", "1e-320*p - 1e-321")
    scene = replace(heavy("9"), events=(*EVENTS, root, nothing, far))
    with pytest.raises(polhode.BadInput) as told:
        polhode.reduce_many(scene, VARIED, keep, number=number)
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_nothing_is_told_of_no_time_at_all():
    said = r"^heavy.toml: at = 0: expected a time other than 0, for lyapunov$"
    with pytest.raises(polhode.BadInput, match=said):
        polhode.reduce_many(heavy("9"), VARIED, "lyapunov", at=[0])


@pytest.mark.filterwarnings("error")
def test_an_expression_is_tried_where_no_component_vanishes():
    found = polhode.reduce_many(heavy("2"), {"start.omega[3]": [1]}, "largest 1/gamma3")
    assert found["largest 1/gamma3"] == pytest.approx([7 / 6], rel=EPS)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("expression", ["sqrt(-1 - gamma3**2)", "1/(p - p)", "sqrt(-p - 9)"])
def test_where_an_expression_has_no_value_there_is_no_number_and_no_warning(expression):
    found = polhode.reduce_many(heavy("2"), {"start.omega[3]": [1]}, f"largest {expression}")
    assert not np.isfinite(found[f"largest {expression}"]).any()


def test_progress_counts_members_and_may_be_a_bar(capsys):
    told = []
    scene = heavy("2")
    plain = polhode.reduce_many(scene, VARIED, "final", progress=lambda *x: told.append(x))
    assert told[-1] == (1.0, 15)
    assert polhode.reduce_many(scene, VARIED, "final", progress=True) == plain
    assert polhode.reduce_many(scene, VARIED, "final", progress=False) == plain


@pytest.mark.parametrize("name", ["nutation", "equator"])
def test_an_event_of_gamma_is_refused_in_a_line_where_there_is_none(name):
    scene = polhode.top(moments=[3, 2, 1.5], omega=[1, 2, 3], end=1)
    with pytest.raises(polhode.BadInput, match=f"keep: first = '?{name}'?: expected an event of"):
        polhode.reduce_many(scene, {"start.omega[1]": [1]}, f"first {name}")
