"""Kappa against differences of perturbed motions; Lyapunov exponents; what they say of digits."""

import math
from dataclasses import replace
from fractions import Fraction
from operator import mul

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode import Body, Scene, conditioning
from polhode.judging import limits
from polhode.judging.conditioning import Band
from shared.motions import asymmetric, in_other_units
from shared.tables import of_run, through
from shared.tools import DOUBLE, QUAD, exactly, examples, mp, tiers

# -- kappa against motions of perturbed inputs ------------------------------------------------


def differences(scene: Scene) -> list[float]:
    """Kappa at the scene's times: each input that is not zero changed by a part of itself.

    Inputs are the components of moments, torque and start along the principal axes.
    """
    body, rows, step = scene.body, scene.body.axes.rows, Fraction(1, 10**15)
    vectors = body.torque, scene.omega, scene.gamma
    inputs = [*body.moments, *(x for vector in vectors for x in body.axes.components(vector))]

    def states(k: int | None = None) -> np.ndarray:
        """Those of the scene in quad; of one whose input k is another."""
        values = [x * (1 + step * (i == k)) for i, x in enumerate(inputs)]
        torque, omega, gamma = (
            [sum(map(mul, values[n : n + 3], column)) for column in zip(*rows, strict=True)]
            for n in (3, 6, 9)
        )
        inertia = [
            [sum(values[n] * rows[n][i] * rows[n][j] for n in range(3)) for j in range(3)]
            for i in range(3)
        ]
        length = (1 + sum(x * x for x in gamma)) / 2  # to first order
        body = Body(inertia, [length * x for x in torque], 1)
        changed = replace(scene, body=body, omega=omega, gamma=gamma, normalise=True)
        run = polhode.integrate(changed, QUAD, project=False, method="taylor")
        sizes = [1] * 3 + [length] * 3
        return np.array(
            [[exactly(x) * y for x, y in zip(row, sizes, strict=True)] for row in run.states]
        )

    honest = states()
    moved = [states(k) for k, x in enumerate(inputs) if x]
    total = sum(abs(x - honest) for x in moved) * step.denominator
    scale = np.linalg.norm(honest[:, :3].astype(float), axis=1).max()
    return [float(max(*(row[:3] / scale), *row[3:])) for row in total.astype(float)]


@pytest.mark.parametrize(("name", "t"), [("euler/turned-axes", 10), ("lagrange/nutation", 2)])
def test_kappa_is_that_of_perturbed_motions(name, t):
    """In turned axes of the scene's components; a symmetric top has five of nine coefficients."""
    scene = polhode.load(name).at((Fraction(t),))
    assert np.allclose(conditioning(scene).kappa, differences(scene), rtol=1e-6)


def test_kappa_of_a_free_body_is_that_of_its_closed_form():
    """w alone: each of p q r A B C changed, the closed form asked."""
    scene, step = polhode.load("euler/no-gamma"), Fraction(1, 10**20)
    end = scene.times[-1:]

    def at(inputs: list) -> np.ndarray:
        changed_scene = replace(scene, body=Body.of_moments(inputs[:3]), omega=tuple(inputs[3:]))
        return np.array([exactly(x) for x in polhode.reference(changed_scene).at(end, 60)[0]])

    inputs = [*scene.body.moments, *scene.omega]
    honest = at(inputs)
    moved = [at([x * (1 + step * (i == j)) for i, x in enumerate(inputs)]) for j in range(6)]
    total = sum(abs(row - honest) for row in moved) * step.denominator
    rows = np.array(polhode.reference(scene).at(scene.times, 20), float)
    scale = np.linalg.norm(rows, axis=1).max()
    assert conditioning(scene).kappa[-1] == pytest.approx(float(max(total)) / scale, rel=1e-6)


def envelope(scene: Scene, t: int) -> float:
    """The largest kappa between t and 1.5 t."""
    return max(conditioning(scene, [t * (1 + Fraction(k, 100)) for k in range(51)]).kappa)


@settings(max_examples=examples(20), deadline=None)
@given(
    st.integers(-60, 60),
    st.integers(-60, 60),
    st.tuples(*[st.integers(-20, 20)] * 3),
    st.integers(1, 30),
)
def test_kappa_does_not_depend_on_units(mass, time, omega, t):
    """Scaling by powers of two changes no bit of it."""

    def kappa(mass: int, time: int) -> tuple:
        m, rate = Fraction(2) ** mass, Fraction(2) ** -time
        body = Body.of_moments([4 * m, 3 * m, 2 * m], [m / 3, m / 2, m], rate**2)
        spin = tuple(rate * w / 8 for w in omega)
        return conditioning(Scene(body, spin, ("0.6", 0, "0.8"), times=(t / rate,))).kappa

    assert kappa(mass, time) == kappa(0, 0)


# -- what is said of it -----------------------------------------------------------------------


def test_a_body_at_rest_upright_stays_the_scenes_own():
    """Kappa grows at an unstable rate, out of a double's range; the state itself stays.

    gamma and the centre lie across the first axis, so that none of their changes tilts the body
    about another: the rate is sqrt(Mg r0/A), not the faster one.
    """
    scene = polhode.load("pendulum/upright")
    far = scene.at((Fraction(1000), Fraction(2000)))
    conditions = conditioning(far, number=mp(1000))
    assert conditions.kappa == (math.inf, math.inf)
    a, b = conditions.log10_kappa
    rate = (b - a) * math.log(10) / 1000
    assert math.isclose(rate, math.sqrt(1 / 1.5), rel_tol=1e-12)
    grown = np.subtract(*conditions.log10_amplification[::-1])  # about the other axis: sqrt(14/15)
    assert math.isclose(grown * math.log(10) / 1000, math.sqrt(14 / 15), rel_tol=1e-6)
    lost = conditioning(far).lost_after
    assert 40 < lost < 45
    assert conditioning(in_other_units(far, 3)).lost_after == 8 * lost
    assert conditioning(far).digits_bound() == (0.0, 0.0)
    assert conditioning(far).expected() == ((0, 0, 0),) * 2


@pytest.mark.slow
def test_no_digits_left_is_said_where_kappa_eats_them_all():
    scene = asymmetric("1.1", [100, 280, 320, 360])
    conditions = conditioning(scene)
    assert conditions.lost == f"no digits left after t = {conditions.lost_after:.3g}"
    assert 280 < conditions.lost_after < 320
    assert conditions.kappa[2:] == (None, None)
    assert conditions.digits_bound()[2:] == conditions.inputs()[2:] == (0.0, 0.0)
    assert conditions.digits_bound("quad")[2:] == (None, None)  # not asked of this computation
    assert conditions.expected("quad")[2:] == conditions.inputs("quad")[2:] == (None, None)
    assert str(conditions).endswith(conditions.lost)
    assert "360" not in str(conditions)
    wider = conditioning(scene, number="quad")
    assert wider.lost == ""
    assert all(12 < d < 30 for d in wider.digits_bound())
    assert wider.lost_after is None


@pytest.mark.parametrize(("spin", "end"), [("3", 1), ("3", 40), ("1.1", 40)])
def test_the_bound_is_kappa_eps(spin, end):
    """And the inputs of one type cost no more."""
    conditions = conditioning(asymmetric(spin, [end]))
    ((least,), (inputs,)) = conditions.digits_bound(), conditions.inputs()
    eps = 52 * math.log10(2)
    assert least == pytest.approx(eps - conditions.log10_kappa[0], abs=1e-9)
    assert least < inputs <= DOUBLE.most_digits
    assert conditions.digits_bound("extended")[0] == pytest.approx(
        least + 11 * math.log10(2), abs=1e-9
    )


def test_a_motion_too_long_for_the_steps_allowed_has_no_kappa():
    scene = asymmetric("3", [10, 10**6])
    conditions = conditioning(scene, max_steps=500)
    assert conditions.kappa[0] is not None
    assert conditions.kappa[1] is None
    rows = conditions.digits_bound(), conditions.expected(), conditions.inputs()
    assert [row[1] for row in rows] == [None] * 3
    assert "kappa not followed" in conditions.note
    assert "500 steps" in str(conditions)


def test_a_run_is_limited_by_what_its_problem_allows():
    """On the separatrix the motion does it; a loose tolerance, a fast spin: the method."""
    apart = polhode.compare(polhode.integrate("euler/separatrix"))
    assert apart.limit == "conditioning"
    assert apart.expected[-1].least < apart.worst < apart.expected[-1].most < 14
    loose = polhode.compare(polhode.integrate("euler/largest-axis", at=[10], tol=1e-7))
    assert loose.limit == "method (tolerance 1.0e-07)"
    assert min(loose.inputs) > loose.worst + 3
    assert min(band.least for band in loose.expected) > loose.worst + 3


@pytest.mark.parametrize(
    ("digits", "expected", "inputs", "reference", "name"),
    [
        (15.5, None, None, math.inf, "rounding"),
        (14.0, (13.9, 14.4, 15.0), 14.0, math.inf, "rounding"),
        (12.2, (11.9, 12.4, 13.0), 12.8, math.inf, "conditioning"),
        (12.2, (11.9, 12.4, 13.0), 12.45, math.inf, "conditioning"),
        (12.2, (11.9, 12.4, 13.0), 12.41, math.inf, "inputs"),
        (14.0, (11.9, 12.4, 13.0), 15.0, math.inf, "conditioning"),
        (11.8, (11.9, 12.4, 13.0), 12.4, math.inf, "method (of it)"),
        (13.8, (13.9, 14.4, 15.0), 14.0, math.inf, "method (of it)"),
        (11.9, None, None, math.inf, limits.UNKNOWN),
        (11.8, (11.9, 12.4, 13.0), 12.4, 12.5, "reference"),
        (0.1, (0.0, 0.0, 0.0), 0.0, 30.0, "conditioning"),
    ],
)
def test_the_limit_has_a_name(digits, expected, inputs, reference, name):
    band = None if expected is None else Band(*expected)
    most = DOUBLE.most_digits
    limit = limits.limit(digits, most, band, inputs, "of it", reference=reference)
    assert limit == name


@pytest.mark.parametrize(("times", "digits"), [(1, 0.0), (2, 0.0583), (11, 0.1607), (301, 0.2836)])
def test_the_worst_of_many_times_may_lie_lower_than_each(times, digits):
    """By twenty thousand runs of independent times: one in twenty falls short at its worst."""
    allowance = limits.selected(times)
    assert abs(allowance - digits) < 1e-4
    errors = np.abs(np.random.default_rng(times).standard_normal((20_000, times))).max(axis=1)
    short = np.mean(errors > 10**allowance * 1.959964)
    assert 0.045 < short < 0.054  # three standard deviations are 0.0046
    band = Band(12.0, 12.5, 13.0)
    for below, name in ((0.01, "conditioning"), (-0.01, "method (of it)")):
        worst = 12.0 - allowance + below
        assert limits.limit(worst, 15.95, band, None, "of it", times) == name


@pytest.mark.usefixtures("compiled_as_for_users")
def test_the_worst_of_many_times_is_no_method_for_being_chosen():
    """The first command of README: 301 times of a run in double, and no fault of its steps."""
    judged = polhode.compare(polhode.integrate("published/nasa-brick"))
    at = judged.digits.index(judged.worst)
    assert judged.worst < judged.expected[at].least  # below the band of that time alone
    assert judged.limit == "rounding"


# -- files of other programs ------------------------------------------------------------------


@pytest.mark.slow
def test_a_table_is_judged_by_the_yardstick_of_a_double():
    """Of times on both sides of 0, and 0 twice."""
    scene, times = asymmetric("3", []), ([0, 1, 40], [0, -40])
    before, after = (of_run(polhode.integrate(scene, at=at)) for at in times)
    columns = {name: np.concatenate([before[name], after[name]]) for name in before}
    judged = polhode.compare(columns, scene)
    assert judged.subject.number == DOUBLE
    assert judged.limit == "conditioning"
    expected = conditioning(scene, [40]).expected(every=0)[0]
    assert judged.expected[2] == pytest.approx(expected, abs=0.02)
    assert len(judged.expected) == len(judged.inputs) == len(judged.times) == 5


def test_few_printed_digits_are_named(tmp_path):
    scene = asymmetric("3", [])
    columns = of_run(polhode.integrate(scene, at=[1, 10]))
    judged = polhode.compare(through("%.7e", columns, tmp_path), scene)
    assert judged.limit == "rounding (of the printed digits)"
    assert 7 < judged.worst < 9


# -- regular motions --------------------------------------------------------------------------

REGULAR = {
    "kovalevskaya/generic": (1, 8),  # a change of A, B, C alone leaves the tori
    "euler/largest-axis": (0.75, 1.25),  # in proportion to t
    "lagrange/nutation": (0.75, 1.25),
    "euler/no-gamma": (0.75, 1.25),
}


@pytest.mark.parametrize("name", tiers(["kovalevskaya/generic"], ["euler/largest-axis"]))
def test_motions_of_integrable_tops_are_regular(name):
    """A tangent grows like t; kappa too, or faster where other moments make it another top."""
    motion = polhode.lyapunov(name)
    assert motion.verdict == "regular"
    assert abs(motion.exponent) < motion.uncertainty
    assert motion.growth == pytest.approx(math.log(2), abs=0.2)
    scene, (least, most) = polhode.load(name), REGULAR[name]
    assert least < envelope(scene, 800) / envelope(scene, 100) / 8 < most
