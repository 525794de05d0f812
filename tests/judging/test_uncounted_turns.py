"""Angles at times to which the closed form does not count turns: judged up to whole turns."""

import pytest

import polhode
from polhode.judging.score import angles_of_attitudes

SCENE = "euler/turned-symmetric"
TIMES = 0, 1, 10**9


def rows(off=0.0):
    """psi, theta, phi of the attitude, psi off by so much and some whole turns."""
    attitude = polhode.reference(SCENE).attitude(TIMES, 30)
    turn = 6.283185307179586476925286766559
    return [
        [float(psi) + off + 3 * turn, float(theta), float(phi)]
        for psi, theta, phi in angles_of_attitudes(attitude, 100)
    ]


def test_angles_that_are_refused_are_judged_up_to_whole_turns():
    with pytest.raises(polhode.BadInput, match="ask for the attitude"):
        polhode.reference(SCENE).angles([TIMES[-1]], 20)
    right = polhode.compare(rows(), SCENE, at=TIMES, columns=("psi", "theta", "phi"))
    assert right.parts["angles"] > 14
    wrong = polhode.compare(rows(1e-5), SCENE, at=TIMES, columns=("psi", "theta", "phi"))
    assert 4.9 < wrong.parts["angles"] < 5.1


def test_at_a_pole_psi_and_phi_are_not_judged():
    assert angles_of_attitudes([[1, 0, 0, 0], [0, 0.6, 0.8, 0]], 60)[0] == [None, 0, None]


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", ["euler/dzhanibekov", "kovalevskaya/generic", SCENE])
def test_a_time_that_is_asked_for_twice_has_its_turns_counted_once(case):
    reference = polhode.reference(case)
    one, two = reference.angles([1, 2], 20)
    assert reference.angles([1, 2, 1, 1], 20) == [one, two, one, one]
    found = polhode.compare([one, two, one], case, at=[1, 2, 1], columns=("psi", "theta", "phi"))
    assert found.parts["angles"] > 15
