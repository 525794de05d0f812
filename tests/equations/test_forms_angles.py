"""Lagrange's, Hamilton's and Routh's equations in the Euler angles of the principal axes.

Judged against the vector equations, and against L = 1/2 w.Iw - Mg r0.gamma itself, with w from the
rotation matrix R = Rz(psi) Rx(theta) Rz(phi) and every derivative of L numerical.
"""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import polhode
from polhode.common.errors import BadInput
from polhode.equations.forms import hamiltonian, lagrangian, routhian
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_mpf
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.number_types import DOUBLE, mp
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared import form_trials as trials
from shared import series
from shared.examples import examples
from shared.form_integrals import form_integrals
from shared.form_trials import MP, STEP, WORKING, close, derivative, numbers, scenes
from shared.motions import asymmetric

F = Fraction
SMALL = mpf(10) ** -12
FORMS = {"lagrangian": lagrangian, "hamiltonian": hamiltonian, "routhian": routhian}
KINDS = ["any", "A = B", "A = C", "B = C", "A = B = C"]
few = settings(max_examples=examples(12), deadline=None)


#: A regular motion of an asymmetric body, away from the poles (sin theta > 0.3).
REGULAR_START = asymmetric(psi=F(1, 3))


def attitude(angles):
    """R = Rz(psi) Rx(theta) Rz(phi)."""

    def turn(i, j, angle):
        m = mpmath.eye(3)
        m[i, i] = m[j, j] = mpmath.cos(angle)
        m[j, i] = mpmath.sin(angle)
        m[i, j] = -m[j, i]
        return m

    psi, theta, phi = angles
    return turn(0, 1, psi) * turn(1, 2, theta) * turn(0, 1, phi)


def taken(kind, scene):
    """The scene in this form; another is drawn where a turn puts the third axis upright."""
    upright = scene.body.axes.components(scene.gamma)[:2] == (0, 0)
    try:
        form = kind.for_scene(scene)
    except BadInput:
        assert upright
        reject()
    assert not upright
    return form


def lagrangian_of(scene):
    """L as a function of angles and rates, in the principal axes and the scene's own units."""
    own = lagrangian.for_scene(scene)
    _, k = numbers(own)
    I, torque = [k[x] for x in "ABC"], [k.get(x, mpf(0)) for x in "xyz"]

    def value(angles, rates):
        R = attitude(angles)
        ahead, behind = (attitude(trials.moved(angles, rates, h)) for h in (STEP, -STEP))
        spin = R.T * (ahead - behind) / (2 * STEP)
        omega = spin[2, 1], spin[0, 2], spin[1, 0]
        kinetic = sum(a * w * w for a, w in zip(I, omega, strict=True)) / 2
        return kinetic - trials.dot(torque, list(R[2, :]))

    return value


def slope(function, point, i, step=SMALL):
    """The derivative by variable i, six points: error step^6, noise 1e-80/step."""
    total = mpf(0)
    for weight, m in ((45, 1), (-9, 2), (1, 3)):
        ends = [[x + s * m * step * (j == i) for j, x in enumerate(point)] for s in (1, -1)]
        total += weight * (function(ends[0]) - function(ends[1]))
    return total / (60 * step)


@pytest.mark.sample(5)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FORMS)
@given(data=st.data())
@few
def test_start_field_and_integrals_are_those_of_the_vector_equations(name, kind, data):
    scene = data.draw(scenes(kind))
    form = taken(FORMS[name], scene)
    trials.check_start_and_field(form)
    trials.check_integrals(form)


@given(scenes(turn=False))
@few
def test_lagranges_equations_hold_for_l_itself(scene):
    """d/dt dL/dq' - dL/dq = 0 with the form's accelerations, all derivatives of L numerical."""
    with mpmath.workdps(WORKING):
        form, L = lagrangian.for_scene(scene), lagrangian_of(scene)
        values, k = numbers(form)
        rates = form.field(values, k, MP)

        def whole(x):
            return L(x[:3], x[3:])

        def momenta(x):
            return [slope(whole, x, 3 + i, mpf(1)) for i in range(3)]  # L is quadratic in them

        changes = derivative(momenta, values, rates, mpf(10) ** -20)
        # errors: the step's square, 1e-40; the spin's own 1e-80 over 1e-20
        assert close(changes, [slope(whole, values, i) for i in range(3)], 35)


@given(scenes(turn=False))
@few
def test_hamiltons_equations_hold_for_the_hamiltonian(scene):
    """The field is (dH/dp, -dH/dq), the momenta are dL/dq', and H is energy: p.q' - L."""
    with mpmath.workdps(WORKING):
        form, L = hamiltonian.for_scene(scene), lagrangian_of(scene)
        values, k = numbers(form)
        rates = form.field(values, k, MP)
        lagrange, _ = numbers(lagrangian.for_scene(scene))
        p = [slope(lambda x: L(lagrange[:3], x), lagrange[3:], i, mpf(1)) for i in range(3)]
        assert close(values[3:], p)

        def energy(x):
            return form_integrals(form, x, k, MP)["h"] / k["mass"]

        assert close([energy(values)], [trials.dot(p, rates[:3]) - L(values[:3], rates[:3])])
        assert close(rates[:3], [slope(energy, values, 3 + i) for i in range(3)])
        assert close(rates[3:], [-slope(energy, values, i) for i in range(3)])


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
@settings(max_examples=examples(6), deadline=None)
def test_rouths_equations_hold_for_the_routhian(kind, data):
    """d/dt dR/dq' - dR/dq = 0 for R = L - f psi', f held, psi' solved from f = dL/dpsi'."""
    with mpmath.workdps(WORKING):
        scene = data.draw(scenes(kind, turn=False))
        form, L = routhian.for_scene(scene), lagrangian_of(scene)
        values, k = numbers(form)
        f = k.get("f", mpf(0))

        def reduced(x):
            angles = [mpf(0), *x[:2]]
            at = [L(angles, [psi1, *x[2:]]) for psi1 in (-1, 0, 1)]
            second, first = at[0] - 2 * at[1] + at[2], (at[2] - at[0]) / 2
            psi1 = (f - first) / second  # L is quadratic in psi'
            return L(angles, [psi1, *x[2:]]) - f * psi1

        def momenta(x):
            return [slope(reduced, x, 2 + i, mpf(1)) for i in range(2)]

        rates = form.field(values, k, MP)
        changes = derivative(momenta, values, rates, mpf(10) ** -20)
        assert close(changes, [slope(reduced, values, i) for i in range(2)], 35)


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
@few
def test_the_routhian_reverses_together_with_f(kind, data):
    """3.14, remark 1: t, f -> -t, -f is a symmetry of the equations."""
    with mpmath.workdps(WORKING):
        form = routhian.for_scene(data.draw(scenes(kind, turn=False)))
        values, k = numbers(form)
        back = [*values[:2], *(-x for x in values[2:])]
        odd = {name: -k[name] for name in ("f", "g") if name in k}
        rates = form.field(values, k, MP)
        mirrored = [*(-x for x in rates[:2]), *rates[2:]]
        assert close(form.field(back, k | odd, MP), mirrored)


def test_the_routhian_does_not_reverse_with_f_kept():
    with mpmath.workdps(WORKING):
        for moments in ((2, F(3, 2), 1), (2, 2, 1), (2, 1, 2), (2, 2, 2)):
            body = Body.of_moments(moments, (F(3, 10), F(1, 5), F(1, 2)), 1)
            form = routhian.for_scene(replace(REGULAR_START, body=body))
            values, k = numbers(form)
            back = [*values[:2], *(-x for x in values[2:])]
            one, other = form.field(values, k, MP), form.field(back, k, MP)
            assert max(abs(a - b) for a, b in zip(one[2:], other[2:], strict=True)) > mpf(1) / 10


@pytest.mark.parametrize("kind", ["A = B", "A = C", "A = B = C"])
@given(data=st.data())
@few
def test_the_reduced_equations_are_the_general_ones(kind, data):
    with mpmath.workdps(WORKING):
        scene = data.draw(scenes(kind, turn=False))
        form = routhian.for_scene(scene)
        A, B, C = scene.body.moments
        reduced = routhian.symmetric if A == B else routhian.about_second_axis
        assert form.reduced is (routhian.spherical if A == B == C else reduced)
        values, k = numbers(form)
        k |= numbers(lagrangian.for_scene(scene))[1]
        whole = replace(form, reduced=routhian.general)
        assert close(form.field(values, k, MP), whole.field(values, k, MP))


def test_a_sphere_has_nothing_of_the_moments_left():
    body = Body.of_moments((2, 2, 2), (0, 0, 1), 1)
    form = routhian.for_scene(replace(REGULAR_START, body=body))
    assert form.reduced is routhian.spherical
    assert not {"n", "e", "B-A", "p.qr", "x", "y"} & set(form.coefficients)


@given(scenes())
@few
def test_the_angles_at_the_start_are_those_of_the_principal_axes_in_the_scenes_attitude(scene):
    with mpmath.workdps(WORKING):
        form = taken(lagrangian, scene)
        bits = mp(WORKING).bits
        g1, g2, g3 = (to_mpf(x, bits) for x in scene.gamma)
        psi = to_mpf(scene.psi, bits)
        whole = attitude([psi, mpmath.acos(g3), mpmath.atan2(g1, g2)])
        axes = mpmath.matrix([[to_mpf(x, bits) for x in row] for row in form.axes.rows])
        assert close(attitude(numbers(form)[0][:3]), whole * axes.T)


# The misprints: the source's printed lines fail where the form's own lines hold.


def errata_state(form):
    values, k = numbers(form)
    s, c = mpmath.sin(values[1]), mpmath.cos(values[1])
    return values, k, s, c, mpmath.sin(values[2]), mpmath.cos(values[2])


def test_misprint_of_the_area_integral_in_angles():
    """3.46 lacks C cos(theta) phi'."""
    with mpmath.workdps(WORKING):
        form = lagrangian.for_scene(REGULAR_START)
        values, k, s, c, sf, cf = errata_state(form)
        A, B, C = (k[x] for x in "ABC")
        psi1, theta1, phi1 = values[3:]
        printed = ((A * sf**2 + B * cf**2) * s**2 + C * c**2) * psi1 + (
            A - B
        ) * s * sf * cf * theta1
        found = form_integrals(form, values, k, MP)["f"] / k["mass"]
        assert close([found], [printed + C * c * phi1])
        assert abs(found - printed) > mpf(1) / 10


def test_misprint_of_the_momentum_of_theta():
    """3.47 has cos(theta) for cos(phi) in p_theta."""
    with mpmath.workdps(WORKING):
        scene = replace(REGULAR_START, gamma=(F(12, 25), F(9, 25), F(4, 5)))
        values, k, s, c, sf, cf = errata_state(hamiltonian.for_scene(scene))
        psi1, theta1, _ = numbers(lagrangian.for_scene(scene))[0][3:]
        A, B = k["A"], k["B"]
        last = (A * cf**2 + B * sf**2) * theta1
        assert close([values[4]], [(A - B) * s * cf * sf * psi1 + last])
        assert abs(values[4] - (A - B) * s * c * sf * psi1 - last) > mpf(1) / 1000


def test_misprint_of_the_rate_of_the_momentum_of_theta():
    """3.52 has sin^2 for sin^3(theta) under its first term."""
    with mpmath.workdps(WORKING):
        form = hamiltonian.for_scene(REGULAR_START)
        values, k, s, c, sf, cf = errata_state(form)
        A, B = k["A"], k["B"]
        f, p_theta, p_phi = values[3:]
        first = (A * cf**2 + B * sf**2) * (f - p_phi * c) * (f * c - p_phi) / (A * B)
        rest = -(A - B) * sf * cf * (f * c - p_phi) * p_theta / (A * B * s**2)
        rest -= (k["x"] * sf + k["y"] * cf) * c - k["z"] * s
        found = form.field(values, k, MP)[4]
        assert close([found], [first / s**3 + rest])
        assert abs(found - first / s**2 - rest) > mpf(1) / 100


# Integrated.


def principal_truth(scene, times, digits):
    """The motion by the power series of tests/shared/series.py, in the scene's axes."""
    body = scene.body
    return series.integrate(
        [list(row) for row in body.inertia],
        [to_mpf(x, 300) for x in scene.omega],
        [to_mpf(x, 300) for x in scene.gamma],
        times,
        digits,
        torque=body.torque,
    )


REGULAR = {
    "asymmetric": REGULAR_START,
    "A = B": replace(
        REGULAR_START, body=Body.of_moments((2, 2, 1), (F(3, 10), F(1, 5), F(1, 2)), 1)
    ),
    "A = C": replace(
        REGULAR_START, body=Body.of_moments((2, F(3, 2), 2), (F(3, 10), 0, F(1, 2)), 1)
    ),
    "sphere": replace(REGULAR_START, body=Body.of_moments((2, 2, 2), (F(3, 10), 0, F(1, 2)), 1)),
}


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("motion", REGULAR)
@pytest.mark.parametrize("name", FORMS)
def test_forty_digits_give_the_principal_motion_to_38(name, motion):
    scene, times = REGULAR[motion], [5, 10]
    form = FORMS[name].for_scene(scene)
    rows, _, outcome = trials.integrated(form, times, mp(41))
    assert outcome is Outcome.REACHED_END
    with mpmath.workdps(60):
        for row, exact in zip(rows, principal_truth(scene, times, 45), strict=True):
            error = max(abs(a - b) for a, b in zip(row, exact, strict=True))
            assert mpf(10) ** -44 < error < mpf(10) ** -38 * max(map(abs, exact))


def passing(miss):
    """A symmetric top that rises from 53 degrees and passes the upper pole at about ``miss``.

    f - C r = miss, and the start has the kinetic energy to pass.
    """
    body, gamma = Body.of_moments((1, 1, F(1, 2)), (0, 0, 1), 1), (F(4, 5), 0, F(3, 5))
    p = (F(1, 2) * (1 - gamma[2]) + miss) / gamma[0]
    return Scene(body, omega=(p, 3, 1), gamma=gamma)


def in_double(form, scene):
    """Error at t = 1 of a run in double, and its steps."""
    rows, run, outcome = trials.integrated(form.for_scene(scene), [1], DOUBLE)
    assert outcome is Outcome.REACHED_END
    with mpmath.workdps(40):
        exact = principal_truth(scene, [1], 30)[0]
        return max(abs(a - b) for a, b in zip(rows[0], exact, strict=True)), run.steps


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lagrangian", "hamiltonian"])
def test_double_loses_the_digits_of_the_miss_in_passing_a_pole(name):
    """The error grows as eps over the miss; measured 0.1 to 20 times that."""
    for miss in (F(1, 10**4), F(1, 10**6), F(1, 10**8)):
        error, _ = in_double(FORMS[name], passing(miss))
        assert mpf("0.02") < error * series.number(miss) / mpf(2) ** -52 < 100, miss
    plain = polhode.integrate(passing(F(1, 10**8)).at((F(1),)), number="double").states[-1]
    with mpmath.workdps(40):
        exact = principal_truth(passing(F(1, 10**8)), [1], 30)[0]
        assert max(abs(mpf(a) - b) for a, b in zip(plain, exact, strict=True)) < 16 * mpf(2) ** -52


@pytest.mark.slow
def test_the_routhian_of_a_symmetric_body_pays_for_a_pole_in_steps_alone():
    """f is given and psi not integrated: nothing is lost, but the steps grow with log(miss)."""
    wide, near = (in_double(routhian, passing(F(1, 10**n))) for n in (1, 8))
    assert max(wide[0], near[0]) < 128 * mpf(2) ** -52
    assert near[1] > 3 * wide[1]


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", FORMS)
def test_distance_is_the_squared_sine_of_theta(name):
    scene = passing(F(1, 10**3))
    form = FORMS[name].for_scene(scene)
    times = [F(i, 400) for i in range(1, 401)]
    rows, _, _ = trials.integrated(form, times, DOUBLE)
    nearest = min(row[3] ** 2 + row[4] ** 2 for row in rows)
    values, k = numbers(form, 20)
    assert close([form.distance(values, k, MP)], [mpf(16) / 25], 14)
    assert nearest < mpf(10) ** -4


@pytest.mark.parametrize("name", FORMS)
def test_a_start_at_the_pole_names_the_form_to_use(name):
    scene = replace(REGULAR_START, gamma=(0, 0, 1))
    with pytest.raises(BadInput, match=f"form = {name}: expected principal: .*sin theta = 0"):
        FORMS[name].for_scene(scene)


@pytest.mark.parametrize("name", FORMS)
def test_a_scene_without_gamma_has_no_angles(name):
    scene = Scene(Body.of_moments((3, 2, 1)), (1, 2, 3))
    with pytest.raises(BadInput, match=r"principal for a scene without start\.gamma"):
        FORMS[name].for_scene(scene)


@pytest.mark.parametrize("name", FORMS)
def test_units_of_any_size_cost_no_digit_and_change_no_variable(name):
    """Moments times 2^80, weight times 2^100 with 2^20 for 4^10: the same numbers inside."""
    one = FORMS[name].for_scene(REGULAR_START)
    body = Body.of_moments(
        [x * 2**80 for x in one.scene.body.moments], one.scene.body.centre, 2**100
    )
    omega = tuple(2**10 * w for w in one.scene.omega)
    other = FORMS[name].for_scene(replace(one.scene, body=body, omega=omega))
    assert [DOUBLE.rounded(x) for x in one.start] == [DOUBLE.rounded(x) for x in other.start]
    for key, x in one.coefficients.items():
        if key != "mass":
            assert mp(60).rounded(x) == mp(60).rounded(other.coefficients[key]), key


def test_nothing_that_vanishes_is_compiled():
    """The Lagrange top in Lagrange's form: no x, no y, no A - B among the constants."""
    form = lagrangian.for_scene(passing(F(1)))
    run = trials.integrated(form, [F(1, 8)], DOUBLE)[1]
    text = str(run.decomposition)
    assert "r.pq" not in form.coefficients
    assert " 0.0" not in text
    assert "(0 *" not in text


# As a scene asks for it.


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", FORMS)
def test_a_turned_body_gives_the_states_of_the_principal_form(name):
    found = trials.both_runs(name)
    assert abs(found[0] - found[1]).max() < 256 * 2**-52
    assert (found[0] != found[1]).any()


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMS)
def test_a_run_that_meets_the_pole_says_so(name):
    scene = replace(passing(F(1, 10**8)), times=(F(1, 8), F(1)), form=name)
    run = polhode.integrate(scene)
    assert run.outcome is polhode.Outcome.SINGULAR
    assert run.advice == "use --form principal"
    assert len(run.states) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMS)
def test_angles_and_attitude_come_out_as_in_the_principal_form(name):
    scene = replace(REGULAR_START, times=(F(1), F(5)), outputs=("angles", "attitude"))
    one, other = (polhode.integrate(replace(scene, form=form)) for form in ("principal", name))
    for found in ("angles", "attitude"):
        rows = zip(getattr(one, found), getattr(other, found), strict=True)
        assert max(abs(a - b) for x, y in rows for a, b in zip(x, y, strict=True)) < 256 * 2**-52


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("name", ["lagrangian", "hamiltonian"])
def test_the_forms_own_psi_is_that_of_the_scene(name):
    """In principal axes the integrated precession is the psi that the output integrates."""
    scene = replace(REGULAR_START, times=(F(5),), outputs=("angles",))
    psi = polhode.integrate(scene).angles[0][0]
    rows = trials.marched(FORMS[name].for_scene(scene), [5])[0]
    assert abs(rows[0][0] - psi) < 256 * 2**-52
