"""Which classical top a body is, about each axis, and that every room asks the one finder."""

from fractions import Fraction

import pytest

import polhode
from polhode.closed_forms.families import closed_forms
from polhode.equations import integrals
from polhode.motion.frame import Frame
from polhode.scenes import body as classification
from polhode.scenes.body import ClassicalTop, classical_top
from shared.tools import case_names

#: moments with the axis of C last, torque, what the body is.
BODIES = [
    ((2, 2, 3), (0, 0, 1), classification.LAGRANGE),
    ((2, 2, 3), (0, 0, -1), classification.LAGRANGE),
    ((2, 2, 1), (0, 0, 1), classification.LAGRANGE),  # of a Kovalevskaya top's moments
    ((1, 1, 1), (0, 0, 1), classification.SPHERE),
    ((2, 2, 1), (1, 0, 0), classification.KOVALEVSKAYA),
    ((2, 2, 1), (3, -4, 0), classification.KOVALEVSKAYA),
    ((4, 4, 1), (1, 2, 0), classification.CHAPLYGIN),
    ((3, 3, 1), (1, 2, 0), classification.SYMMETRIC),
    ((2, 2, 1), (1, 0, 1), classification.SYMMETRIC),
    ((4, 4, 1), (0, 1, 1), classification.SYMMETRIC),
]


#: The same of bodies that are another top about no axis.
ROUND = [
    ((2, 2, 1), (0, 0, 0), classification.EULER),
    ((1, 1, 1), (1, 0, 2), classification.SPHERE),
    ((2, 3, 4), (0, 0, 1), classification.ASYMMETRIC),
]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("moments", "torque", "kind"), [*BODIES, *ROUND])
def test_a_top_is_found_about_every_axis(moments, torque, kind, axis):
    body, weight = [None] * 3, [None] * 3
    for i, a, t in zip(classification.with_last(axis), moments, torque, strict=True):
        body[i], weight[i] = Fraction(a), Fraction(t)
    about = None if (moments, torque, kind) in ROUND else axis
    assert classical_top(tuple(body), tuple(weight)) == ClassicalTop(kind, about)


def test_integrals_and_closed_forms_agree_with_the_finder():
    """Over the library: a closed form that depends on the body alone, its integral, its name."""
    by_kind = {
        classification.EULER: ("euler", integrals.MOMENTUM),
        classification.LAGRANGE: ("lagrange", integrals.SPIN),
        classification.SPHERE: ("lagrange", integrals.SPIN),
        classification.KOVALEVSKAYA: ("kovalevskaya", integrals.KOVALEVSKAYA),
    }
    met = set()
    for name in case_names():
        scene = polhode.load(name)
        kind = classification.kind_of_body(scene.body)
        met.add(kind)
        if kind not in by_kind:
            continue
        family, integral = by_kind[kind]
        first = next(closed_forms(scene), None)
        if name == "kovalevskaya/multiply-degenerate":  # two double roots: an enclosure judges it
            assert first is None
            continue
        assert first is not None
        if family == "kovalevskaya":  # motions of other bodies too are theirs
            assert first[0] in (family, "pendulum", "bobylev-steklov")
        else:
            assert first[0] == family
        inside = Frame.of(scene).inside(scene)
        assert integrals.first_integrals(inside).onto[-1] == integral
    assert met >= set(by_kind)
