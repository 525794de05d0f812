"""Refined runs against closed forms, against themselves in other intervals, at their limits."""

import random
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

import polhode
from polhode.common.errors import BadInput
from polhode.numbers.conversion import exactly
from polhode.refined import double_run, refinement, self_test
from polhode.refined.compiled_field import Kernels, kernels
from polhode.refined.errors import CannotRefine, TooFarOff
from polhode.refined.refinement import QUAD, Accuracy, accuracy, refine
from polhode.scenes import library
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared.motions import ASYMMETRIC, asymmetric


def run(scene, *times, wanted=QUAD, **options):
    """A refinement at times in the scene's units."""
    unit = Fraction(2) ** scene.time_unit
    return refine(scene, [Fraction(t) / unit for t in times], wanted, **options)


def distance(found, other, i=-1):
    """Largest differences of w and of gamma."""
    pairs = list(zip(found.exactly(i), other.exactly(i), strict=True))
    return [max(abs(float(a - b)) for a, b in pairs[k : k + 3]) for k in (0, 3)]


def error(found, scene, t, i=-1, digits=45):
    """Largest errors of w and gamma, w in the scene's own unit, by the closed form."""
    exact = [exactly(x) for x in polhode.reference(scene).at([t], digits)[0]]
    exact[:3] = [x * Fraction(2) ** scene.time_unit for x in exact[:3]]
    pairs = list(zip(found.exactly(i), exact, strict=False))
    return [max([abs(float(a - b)) for a, b in pairs[k : k + 3]] or [0.0]) for k in (0, 3)]


def within(errors, found, i=-1):
    return bool((np.array(errors) <= found.estimate.errors[i]).all())


CLOSED = [  # case, end, least and most correct digits of w and gamma
    ("euler/flat", 100, 33.5, 36.5),
    ("euler/dzhanibekov", 30, 30, 33),
    ("euler/backward", -100, 33.5, 36.5),
    ("euler/tiny-units", 100, 34, 37),
    ("lagrange/spherical-pendulum", 40, 33.5, 36.5),
    ("kovalevskaya/generic", 20, 34, 36.5),
    ("kovalevskaya/bobylev-steklov", 20, 33, 36),
    ("pendulum/upright", 20, 28, 31),
    ("hard/dzhanibekov-1e-9", 50, 30, 33),
    ("hard/near-homoclinic", 40, 25, 29),
]


@pytest.mark.parametrize(("name", "end", "least", "most"), CLOSED)
def test_closed_forms_and_the_estimate(name, end, least, most):
    scene = library.load(name)
    times = [Fraction(end, 7), Fraction(end)]
    found = run(scene, *times)
    for i, t in enumerate(times):
        errors = error(found, scene, t, i)
        assert within(errors, found, i)
    digits = -np.log10(max(errors))
    assert least <= digits <= most
    assert max(found.estimate.errors[-1]) < 1e6 * max(errors)  # an estimate that says something


def test_another_grouping_of_steps_agrees_within_the_estimate():
    draw = random.Random(5)
    for k in range(8):
        a, b = (Fraction(draw.randint(20, 100), 50) for _ in range(2))
        c = a + b - Fraction(draw.randint(1, 80), 50) * min(a, b)
        moments = [a, b, c] if k % 4 else [a, a, a / 10000]  # slender, too
        centre = [Fraction(draw.randint(-50, 50), 100) for _ in range(3)]
        body = Body.of_moments(moments, centre, 0 if k == 5 else 1)
        omega = tuple(Fraction(draw.randint(-200, 200), 100) for _ in range(3))
        scene = Scene(body, omega, ("0.48", "0.6", "0.64"))
        end = 10 if k % 2 else -10
        six, five = run(scene, end), run(scene, end, m=5)
        assert within(distance(six, five), six)
        assert six.states != five.states
        assert six.intervals <= five.intervals


@dataclass(frozen=True)
class FewNodes(Accuracy):
    """So many nodes, however few they are."""

    count: int = 12

    def nodes(self, m):
        return self.count

    @property
    def tail(self):
        return 1.0


def test_the_ends_are_good_to_the_square_of_the_stages():
    """Two more nodes take away what two more Legendre coefficients are, squared: 5² to the 4th
    power at best; measured 60 to 80 a node."""
    scene, end = asymmetric(), 100
    true = run(scene, end, wanted=accuracy(40))
    errors = [
        max(distance(run(scene, end, wanted=FewNodes(1e-34, QUAD.limbs, 8, n), m=4), true))
        for n in (15, 17, 19, 21)
    ]
    assert 1e-23 < errors[0] < 1e-20
    for before, after in pairwise(errors):
        assert 1e3 < before / after < 2e4


def test_what_few_nodes_neglect_is_within_the_estimate_and_not_far_below():
    """Ends within one interval or two, where no motion multiplies errors and none cancel: of all
    motions the worst one is some 4 times better than its estimate."""
    worst = []
    for scene in (
        asymmetric(),
        library.load("kovalevskaya/generic"),
        library.load("lagrange/spherical-pendulum"),
        library.load("euler/dzhanibekov"),
    ):
        ends = [Fraction(k, 4) for k in range(1, 9)]
        true = run(scene, *ends, wanted=accuracy(40))
        for count in (9, 11, 13):
            found = run(scene, *ends, wanted=FewNodes(1e-34, QUAD.limbs, 8, count))
            for i in range(len(ends)):
                off = distance(found, true, i)
                assert within(off, found, i)
                worst.append(max(found.estimate.errors[i]) / max(off))
    assert 2 < min(worst) < 20


def test_guesses_that_are_off_change_less_than_the_estimate(monkeypatch):
    scene = asymmetric()
    found = run(scene, 30)
    before, draw = double_run.Base.states, np.random.default_rng(3)
    monkeypatch.setattr(
        double_run.Base,
        "states",
        lambda self, t: before(self, t) + draw.uniform(-1e-12, 1e-12, (6, *t.shape)),
    )
    other = run(scene, 30)
    assert other.states != found.states
    assert within(distance(found, other), found)
    assert within(distance(found, other), other)


def test_guesses_too_far_off_are_refused(monkeypatch):
    before, draw = double_run.Base.states, np.random.default_rng(3)
    monkeypatch.setattr(
        double_run.Base,
        "states",
        lambda self, t: before(self, t) + draw.uniform(-1e-5, 1e-5, (6, *t.shape)),
    )
    with pytest.raises(CannotRefine, match="drifts within one interval"):
        run(asymmetric(), 30)


def test_there_and_back():
    scene = asymmetric()
    there = run(scene, 50)
    unit = Fraction(2) ** scene.time_unit
    end = there.exactly(0)
    # gamma is of length 1 to 1e-35 only: the start of the way back is not checked, but given
    from polhode.refined import refinement
    from polhode.refined.scaled_problem import problem

    exact = problem(scene, 200, backward=False)
    back = refinement._Run(
        replace(exact, state=(*(-x for x in end[:3]), *end[3:])), [50 / unit], QUAD, 6
    )
    back.to_the_end(None, None)
    home = [Fraction(x, 1 << there.bits) for x in back.found[0]]
    home = [-x for x in home[:3]] + home[3:]
    off = max(abs(float(a - b)) for a, b in zip(home, exact.state, strict=True))
    assert 0 < off < there.estimate.kappa[0] * 1e-33
    assert off < 2 * there.estimate.kappa[0] * there.estimate.errors[0].max()


def test_outputs_do_not_change_the_motion_and_agree_with_a_run_that_ends_there():
    scene = asymmetric()
    ends = [Fraction(k, 7) for k in range(1, 71)]
    many, one = run(scene, 0, *ends), run(scene, 10)
    assert max(distance(many, one)) < 2e-36  # the sums in double, not the levels, know of others
    start = [*(x * Fraction(2) ** scene.time_unit for x in scene.omega), *scene.gamma]
    assert max(abs(float(a - b)) for a, b in zip(many.exactly(0), start, strict=True)) < 1e-37
    for i in (1, 20, 45):
        alone = run(scene, ends[i - 1])
        assert max(distance_at(many, i, alone)) < 1e-35


def distance_at(found, i, other):
    pairs = list(zip(found.exactly(i), other.exactly(0), strict=True))
    return [abs(float(a - b)) for a, b in pairs]


def test_outputs_that_crowd():
    scene = asymmetric()
    crowd = [1 + Fraction(k, 10**6) for k in range(700)]
    found, last = run(scene, *crowd, 3), run(scene, 3)
    assert len(found.states) == 701
    assert within(distance(found, last), last)
    alone = run(scene, crowd[650])
    assert max(distance_at(found, 650, alone)) < 1e-35


def test_backward_is_forward_with_the_rates_turned_about():
    scene = asymmetric()
    turned = replace(scene, omega=tuple(-w for w in scene.omega))
    back, forward = run(scene, -5, -20), run(turned, 5, 20)
    for a, b in zip(back.states, forward.states, strict=True):
        assert a == [-x for x in b[:3]] + b[3:]


def test_the_unit_of_time_changes_no_bit():
    scene = asymmetric()
    factor = Fraction(2) ** 40
    fast = asymmetric(rate=factor)
    assert fast.time_unit != scene.time_unit
    assert run(scene, 20).states == run(fast, 20 / factor).states


def test_a_body_that_hangs_at_rest_or_has_nothing_to_move_it():
    hanging = Scene(Body.of_moments([2, "1.5", 1], [0, 0, 1], 1), (0, 0, 0), (0, 0, -1))
    still = Scene(Body.of_moments([2, "1.5", 1]), (0, 0, 0), (0, 0, 1))
    for scene in (hanging, still):
        found = run(scene, 100)
        start = [*scene.omega, *scene.gamma]
        assert max(abs(float(a - b)) for a, b in zip(found.exactly(0), start, strict=True)) < 1e-35
        assert np.isfinite(found.estimate.errors).all()


def test_released_from_rest():
    scene = Scene(ASYMMETRIC, (0, 0, 0), (1, 0, 0))
    found, five = run(scene, 10), run(scene, 10, m=5)
    assert within(distance(found, five), found)
    assert max(found.estimate.errors[0]) < 1e-31


def test_a_violent_pendulum_cuts_its_intervals():
    scene = replace(asymmetric(), body=replace(ASYMMETRIC, weight=50))
    found, five = run(scene, 10), run(scene, 10, m=5)
    assert found.intervals > found.steps / 6
    assert within(distance(found, five), found)


def test_no_estimate_where_the_motion_multiplies_errors_too_much():
    found = run(library.load("hard/chaotic-long"), 30, 330)
    assert np.isfinite(found.estimate.errors[0]).all()
    assert found.estimate.kappa[1] > 1e14
    assert np.isinf(found.estimate.errors[1]).all()


def test_fifty_digits():
    scene = library.load("lagrange/spherical-pendulum")
    found = run(scene, 5, wanted=accuracy(50))
    errors = error(found, scene, 5, digits=62)
    assert within(errors, found)
    assert 1e-56 < max(errors) < 1e-50
    assert max(found.estimate.errors[0]) < 1e-47


@pytest.mark.campaign  # the field in 15 limbs takes ten seconds to compile where no cache holds it
def test_a_hundred_digits_by_the_closed_form():
    scene = library.load("kovalevskaya/generic")
    found = run(scene, 3, wanted=accuracy(100))
    errors = error(found, scene, Fraction(3), digits=112)
    assert within(errors, found)
    assert 1e-110 < max(errors) < 1e-99


def test_only_the_principal_form_is_refined():
    with pytest.raises(BadInput, match="principal"):
        run(replace(asymmetric(), form="general"), 1)


def test_progress_is_told_and_an_interrupt_stops_the_run():
    scene, told = asymmetric(), []
    whole = run(scene, 50, 300, progress=lambda done, steps: told.append((done, steps)))
    assert told == sorted(told)
    assert len(told) >= 2
    assert 0 < told[0][0] < told[-1][0] <= 1
    assert whole.stopped is None
    assert whole.reached == whole.times[-1]

    def stop(done, steps):
        raise KeyboardInterrupt

    part = run(scene, 50, 300, progress=stop)
    assert part.stopped == "interrupted"
    assert whole.times[0] <= part.reached < whole.reached
    assert part.states == whole.states[:1]
    assert len(part.estimate.errors) == 1
    nothing = run(scene, 300, progress=stop)
    assert nothing.states == []
    assert nothing.reached > 0


def test_a_limit_on_the_steps_of_the_double_run():
    found = run(asymmetric(), 10, 300, max_steps=300)
    assert found.stopped == "step limit"
    assert found.steps == 300
    assert len(found.states) == 1


def test_the_state_at_any_time_from_the_last_block_before_it():
    scene = asymmetric()
    unit = Fraction(2) ** scene.time_unit
    found = run(scene, 300)
    times = [Fraction(t) / unit for t in ("299", "17", "1/3", "0", "250.125", "17")]
    assert found.at(found.times) == found.states
    together = found.at(times)
    for t, state in zip(times, together, strict=True):
        alone = found.at([t])[0]  # in other company: another run in double
        assert off(state, alone) < 1e-34 * 2**found.bits
        if t:
            assert off(state, refine(scene, [t]).states[0]) < 1e-33 * 2**found.bits
    start = [x * 2**found.bits for x in (*(w * unit for w in scene.omega), *scene.gamma)]
    assert off(together[3], start) < 1e-37 * 2**found.bits


def off(state, other):
    return max(abs(a - b) for a, b in zip(state, other, strict=True))


def test_a_compiler_that_reassociates_is_found_out(monkeypatch):
    import heyoka

    def careless(out, given, **options):
        return compiled(out, given, fast_math=True, **options)

    compiled = heyoka.cfunc
    monkeypatch.setattr("polhode.refined.compiled_field.hy.cfunc", careless)
    spoilt = kernels.__wrapped__(QUAD.limbs)
    assert self_test.field_error(spoilt, QUAD.limbs) > 2.0**-QUAD.limbs.bits


@pytest.mark.parametrize("output", range(24))
def test_a_fault_in_any_limb_of_the_field_is_found_out(output):
    good = kernels(QUAD.limbs)

    def off(given, pars, outputs):
        good.field(given, pars=pars, outputs=outputs)
        outputs[output] *= 1 + (2.0**-20 if output % 4 == 3 else 2.0**-52)

    limbs = QUAD.limbs
    faulty = self_test.field_error(Kernels(off, *good[1:]), limbs)
    assert self_test.field_error(good, limbs) < 2.0**-limbs.bits
    assert faulty > 2 * self_test.field_error(good, limbs)


def test_a_failed_self_test_refuses_refinement(monkeypatch):
    monkeypatch.setattr(self_test, "field_error", lambda *_: 1e-30)
    self_test.trusted_kernels.cache_clear()
    with pytest.raises(CannotRefine, match="self-test"):
        run(asymmetric(), 1)
    self_test.trusted_kernels.cache_clear()


def test_threads_do_not_disturb_each_other():
    import heyoka

    scenes = [asymmetric(), asymmetric("1.1"), asymmetric("5")]
    alone = [run(scene, 20).states for scene in scenes]
    before = heyoka.get_nthreads()
    with ThreadPoolExecutor(3) as pool:
        together = list(pool.map(lambda scene: run(scene, 20).states, scenes * 3))
    assert together == alone * 3
    assert heyoka.get_nthreads() == before


def test_a_block_of_one_interval_is_one(monkeypatch):
    """As many as are still near the run in double: one is enough, none is not."""
    scene = polhode.load("euler/flat")
    solve, good = refinement.solve, [1]
    whole = run(scene, 9)

    def astray(*arguments):
        if good:
            raise TooFarOff(good.pop())
        return solve(*arguments)

    monkeypatch.setattr(refinement, "solve", astray)
    found = run(scene, 9)
    assert not good
    assert found.estimate.errors[-1].max() < 1e-32
    assert max(distance(found, whole)) < 1e-32
    good.append(0)
    with pytest.raises(CannotRefine, match="within one interval"):
        run(scene, 9)
