"""The eleven forms against the vector equations with the full inertia matrix, at 50 digits."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import polhode
from polhode.cli import main
from polhode.equations.form import equations
from polhode.motion.frame import along
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.vectors import cross, dot, inverse
from polhode.scenes.vocabulary import FORMS
from shared.form_trials import (
    BITS,
    MP,
    WORKING,
    close,
    derivative,
    numbers,
    scenes,
    state,
    vector_field,
)
from shared.tools import examples

KINDS = ("any", "A = B", "A = C", "B = C", "A = B = C")
IN_ANGLES = ("lagrangian", "hamiltonian", "routhian")
ALONE = ("omega-only", "momentum-only")
few = settings(max_examples=examples(20), deadline=None)


def formed(name, scene):
    """The scene in a form; another is drawn where its start is refused, rightly."""
    gamma = scene.body.axes.components(scene.gamma)
    across = cross(scene.body.momentum(scene.omega), scene.body.torque)
    singular = {0: gamma[:2], 1: across}.get((name not in IN_ANGLES) + (name not in ALONE), ())
    try:
        return equations(replace(scene, form=name))
    except polhode.BadInput:
        assert singular
        assert not any(sign(x) for x in singular)
        reject()


#: Routh's equations are other ones for each kind of body.
CASES = [(name, "") for name in FORMS if name != "routhian"] + [("routhian", x) for x in KINDS]


@pytest.mark.parametrize(("name", "kind"), CASES)
@given(data=st.data())
@few
def test_start_and_field_are_those_of_the_vector_equations(name, kind, data):
    """And psi', where a form has it; the distance of the start from the singular set."""
    scene = data.draw(scenes(kind or data.draw(st.sampled_from(KINDS))))
    form = formed(name, scene)
    unit = mpf(2) ** scene.time_unit
    with mpmath.workdps(WORKING):
        values, k = numbers(form)
        row, rates = state(form, values, k), form.field(values, k, MP)
        assert close(row, [to_mpf(x, BITS) for x in scene.start])
        changes = derivative(lambda x: state(form, x, k), values, rates)
        assert close([x / unit for x in changes], vector_field(scene, row))
        if "psi" in form.variables:
            (p, q, _), (g1, g2, _) = form.state(values, k, MP)
            assert close([values[0], rates[0]], [mpf(1) / 3, (p * g1 + q * g2) / (g1**2 + g2**2)])
        distance = form.distance(values, k, MP)
        if name in IN_ANGLES:
            assert close([distance], [1 - form.state(values, k, MP)[1][2] ** 2])
        elif name in ALONE:
            assert 0 < distance <= 1
        else:
            assert distance is None


@pytest.mark.parametrize(("name", "power"), [("omega-only", 1), ("quaternion", 2)])
@given(scene=scenes())
@few
def test_what_holds_the_length_of_gamma_is_an_integral_off_its_value_too(name, power, scene):
    """D off its constraint by 1/10, a quaternion of another length: gamma is formed of it as is."""
    form = formed(name, scene)
    with mpmath.workdps(WORKING):
        values, k = numbers(form)
        if power == 1:
            values[3] += mpf(1) / 10
        else:
            values[3:] = [x * mpf("1.25") for x in values[3:]]
            assert form.unit == slice(3, 7)

        def length(x):
            gamma = form.state(x, k, MP)[1]
            return [mpmath.fdot(gamma, gamma)]

        assert close(derivative(length, values, form.field(values, k, MP)), [0])
        assert power == 1 or close(length(values), [mpf("1.25") ** 4])


@pytest.mark.parametrize("name", ["inertia-axes", "gyration-axes"])
@given(scene=scenes())
@few
def test_axes_go_through_the_centre_of_mass_and_leave_out_one_product(name, scene):
    """Right-handed orthonormal, z along Mg r0 (unless 0), I12 or A12 = 0, all of it exactly."""
    form, body = equations(replace(scene, form=name)), scene.body
    axes = form.frame.axes
    x, y, z = axes.directions
    assert [sign(dot(a, b)) for a, b in ((x, y), (y, z), (z, x))] == [0, 0, 0]
    assert sign(dot(cross(x, y), z)) > 0
    assert all(dot(u, u) == n for u, n in zip((x, y, z), axes.squares, strict=True))
    matrix = body.inertia if name == "inertia-axes" else inverse(body.inertia)
    assert along(axes, matrix)[0][1] == 0
    across = [sign(t) for t in axes.components(body.torque)]
    assert across == [0, 0, not body.torque_free]
    assert not {k for k in form.coefficients if k.endswith(".gamma3")}


THIRD = Fraction(1, 3)
SPHERE = {"inertia": [[THIRD, 0, 0], [0, THIRD, 0], [0, 0, THIRD]], "centre": [1, 2, 2]}
TOP = {"moments": [2, 2, 1], "centre": [0, 0, 1]}


PULLS = "p.gamma2 p.gamma3 q.gamma1 q.gamma3 r.gamma1 r.gamma2"
#: Of a form and a body the coefficients that there are: none that vanishes, and all others.
LEFT = [
    ("general", SPHERE, PULLS),
    ("momentum", SPHERE, "P.gamma2 P.gamma3 Q.gamma1 Q.gamma3 R.gamma1 R.gamma2 p.P q.Q r.R"),
    ("inertia-axes", SPHERE, "p.gamma2 q.gamma1"),
    ("gyration-axes", SPHERE, "P.gamma2 Q.gamma1 p.P q.Q r.R"),
    ("principal", {"moments": [1, 2, 3]}, "p.qr q.rp r.pq"),
    ("principal", {"moments": [2, 2, 3]}, "p.qr q.rp"),
    ("principal", {"moments": [2, 2, 2]}, ""),
    ("principal", TOP, "p.gamma2 p.qr q.gamma1 q.rp"),
    ("principal", TOP | {"centre": [1, 0, 0]}, "p.qr q.gamma3 q.rp r.gamma2"),
    ("lagrangian", TOP, "A B C mass p.gamma2 p.qr q.gamma1 q.rp z"),
    ("hamiltonian", TOP, "1/A 1/B 1/C A B C mass z"),
    ("routhian", TOP, "1/A 1/C A B C f g l mass n n.g2 z"),
    ("routhian", SPHERE, "1/A 1/C A B C f g mass x y z"),
]


@pytest.mark.parametrize(("form", "body", "left"), LEFT)
def test_a_coefficient_that_vanishes_is_none(form, body, left, tmp_path, capsys):
    """Exactly: 1/3 - 1/3 is nothing, in any axes."""
    start = {"omega": [1, 2, 3], "gamma": ["3/5", 0, "4/5"], "weight": int("centre" in body)}
    scene = polhode.top(**body, **start, form=form)
    (path := tmp_path / "top.toml").write_text(polhode.as_toml(scene))
    assert main(["show", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["coefficients"] == left.split()
