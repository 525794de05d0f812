"""The forms with polynomial fields: general, inertia-axes, principal, momentum, gyration-axes,
quaternion.  Judged against the vector equations with the full inertia matrix, at 50 digits."""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode.equations.form import equations
from polhode.equations.forms import matrices
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes.body import Body, cross, dot
from polhode.scenes.scene import Scene
from shared import form_trials as trials
from shared.examples import examples
from shared.form_trials import MP, WORKING, close, numbers, scenes

F = Fraction
NAMES = ("general", "inertia-axes", "principal", "momentum", "gyration-axes", "quaternion")
CENTRED = ("inertia-axes", "gyration-axes")
few = settings(max_examples=examples(12), deadline=None)


@pytest.mark.sample(7)
@pytest.mark.parametrize("kind", ["any", "A = B", "A = B = C"])
@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@few
def test_start_and_field_are_those_of_the_vector_equations(name, kind, data):
    trials.check_start_and_field(equations(replace(data.draw(scenes(kind)), form=name)))


@pytest.mark.parametrize("name", CENTRED)
@given(scene=scenes())
@few
def test_axes_go_through_the_centre_of_mass_and_leave_out_one_product(name, scene):
    """Right-handed orthonormal, z along Mg r0 (unless 0), I12 or A12 = 0, all of it exactly."""
    form, body = equations(replace(scene, form=name)), scene.body
    x, y, z = form.axes.directions
    assert [sign(dot(a, b)) for a, b in ((x, y), (y, z), (z, x))] == [0, 0, 0]
    assert sign(dot(cross(x, y), z)) > 0
    assert all(dot(u, u) == n for u, n in zip((x, y, z), form.axes.squares, strict=True))
    matrix = body.inertia if name == "inertia-axes" else matrices.inverse(body.inertia)
    assert matrices.along(form.axes, matrix)[0][1] == 0
    across = [sign(t) for t in form.axes.components(body.torque)]
    assert across == [0, 0, not body.torque_free]
    assert not {k for k in form.coefficients if k.endswith(".gamma3")}


@given(scene=scenes())
@few
def test_the_length_of_the_quaternion_is_an_integral_and_shows_in_gamma(scene):
    """gamma is formed from q as it is: |gamma| = |q|², also off the unit sphere."""
    with mpmath.workdps(WORKING):
        form = equations(replace(scene, form="quaternion"))
        values, k = numbers(form)
        values = values[:3] + [x * mpmath.mpf("1.25") for x in values[3:]]
        _, gamma = form.state(values, k, MP)
        q = values[form.unit]
        assert close([mpmath.fdot(gamma, gamma)], [mpmath.fdot(q, q) ** 2])
        assert close([mpmath.fdot(q, form.field(values, k, MP)[form.unit])], [0])


def test_equal_moments_cancel_exactly_in_any_axes():
    """(1/3 - 1/3) leaves no coefficient; a sphere turned anyhow has no quadratic term at all."""
    third = F(1, 3)
    body = Body(((third, 0, 0), (0, third, 0), (0, 0, third)), (1, 2, 2), 1)
    scene = Scene(body, (1, 2, 3), (F(3, 5), 0, F(4, 5)))
    for name in ("general", "momentum", *CENTRED):
        rates = {k.split(".")[1] for k in equations(replace(scene, form=name)).coefficients}
        assert rates <= {"gamma1", "gamma2", "gamma3", "P", "Q", "R"}


@pytest.mark.parametrize("name", NAMES[:-1])
def test_a_torque_free_scene_without_gamma_has_three_equations(name):
    scene = replace(polhode.load("euler/no-gamma"), form=name)
    assert len(equations(scene).variables) == 3
    found = polhode.integrate(scene, "quad", at=[5]).states
    assert len(found[0]) == 3
    trusted = polhode.integrate(replace(scene, form="principal"), "quad", at=[5]).states
    assert close([exactly(x) for x in found[0]], [exactly(x) for x in trusted[0]], 31)


def test_the_quaternion_form_needs_gamma_to_begin_from():
    scene = replace(polhode.load("euler/no-gamma"), form="quaternion")
    with pytest.raises(polhode.BadInput, match="the attitude begins from it"):
        polhode.integrate(scene, at=[1])


def test_the_norm_of_the_quaternion_is_held_by_corrections_that_are_reported():
    scene = replace(polhode.load("kovalevskaya/generic"), form="quaternion", outputs=())
    run = polhode.integrate(scene, at=[2000])
    found = run.projection
    assert found.onto == ("|q|",)
    assert found.count == run.steps // found.every
    eps = float(run.number.eps)
    assert eps / 4 < found.largest < 100 * eps
    assert found.largest <= found.sum <= found.count * found.largest
    plain = polhode.integrate(replace(scene, form="principal"), at=[20])
    assert "|q|" not in plain.projection.onto
