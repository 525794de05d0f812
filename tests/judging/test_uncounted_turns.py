"""Angles at times so late that no run tells their turns: judged up to whole turns."""

import pytest

import polhode
from polhode.judging import reference
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


@pytest.mark.parametrize("case", ["euler/dzhanibekov", "kovalevskaya/generic", SCENE])
def test_times_may_be_asked_for_twice_and_in_any_order(case):
    exact = polhode.reference(case)
    first, second, back = exact.angles([1, 2, -1], 20)
    assert exact.angles([2, -1, 1, 1], 20) == [second, back, first, first]
    judged = polhode.compare(
        [first, second, first], case, at=[1, 2, 1], columns=("psi", "theta", "phi")
    )
    assert judged.parts["angles"] > 15


def test_a_run_that_leaves_the_motion_tells_no_turns(monkeypatch):
    """On the separatrix: rounding takes a run in double away from it, and there psi is another."""
    exact = polhode.reference("euler/separatrix")
    ((psi, _, phi),) = exact.angles([200], 20)  # by more digits
    assert (round(float(psi)), round(float(phi))) == (209, 7)
    monkeypatch.setattr(reference, "_TURNING", reference._TURNING[:1])
    assert None not in exact.angles([5], 20)[0]
    with pytest.raises(polhode.BadInput, match="went round to t = 200 is not known"):
        exact.angles([5, 200], 20)
