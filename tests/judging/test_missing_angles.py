"""Motions that end at a pole: psi and phi of their many rows there, asked for as far as needed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging._dense_reference.columns import in_panels
from polhode.judging.references.reference import rows
from polhode.judging.score import score

NAMES = ("psi", "theta", "phi")
COUNT = 1500
FIRST_LOOK = 5  # rows at which conventions are looked for


@pytest.fixture
def asked(monkeypatch):
    """How many angles of the closed form a comparison asks for after its panels."""
    found, plain = [], score.HeldAgainst._ask

    def asking(self, question):
        ask = plain(self, question)
        return lambda times, digits: found.append(len(times)) or ask(times, digits)

    monkeypatch.setattr(score.HeldAgainst, "_ask", asking)
    return found


@pytest.fixture(scope="module")
def known():
    """A top that tends to the pole, and its true angles."""
    scene = polhode.load("lagrange/homoclinic").at([Fraction(k, 40) for k in range(COUNT)])
    true = polhode.reference(scene).angles(scene.times, 17)
    return scene, np.array([[float(x) for x in row] for row in true])


@pytest.fixture
def homoclinic(known):
    scene, table = known
    return scene, table.copy()


def judged(scene, table):
    return polhode.compare(table, scene, at=scene.times, columns=NAMES)


def test_panels_tell_theta_where_they_do_not_tell_psi():
    reference = polhode.reference("lagrange/homoclinic")
    times = [Fraction(k, 40) for k in range(COUNT)]
    found = in_panels(reference, times, 19, ("angles",), 1)
    untold = [*found.untold]
    assert 100 < len(untold) < COUNT - 100
    assert untold == np.nonzero(np.isnan(found.angles[0].hi))[0].tolist()
    for k in (0, 200, untold[0], untold[-1]):
        (true,) = rows(reference.angles, [times[k]], 25)
        for which, x in enumerate(true):
            if which == 1 or k not in untold:
                assert abs((found.angles[which][k] - x).hi) < 1e-19


@pytest.mark.slow
def test_right_angles_are_judged_to_the_last(asked, homoclinic):
    scene, table = homoclinic
    found = judged(scene, table)
    assert 13.5 < found.parts["angles"] < 17
    untold = found._held.many.untold
    assert sum(asked) == FIRST_LOOK + len(untold), "each once"
    table[untold[77], 2] += 1e-9  # of phi
    assert 8.9 < judged(scene, table).parts["angles"] < 9.1
    table[untold[78], 1] += 1e-8  # of theta
    assert 7.9 < judged(scene, table).parts["angles"] < 8.1


@pytest.mark.slow
def test_angles_of_no_digits_are_not_asked_for_again(asked, homoclinic):
    scene, table = homoclinic
    table[:, 0] = np.where(np.arange(COUNT) < 600, table[:, 0], -25)
    found = judged(scene, table)
    assert len(found._held.many.untold) > 100
    assert found.parts["angles"] == 0
    assert sum(asked) <= 32


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_cells_that_are_empty_are_not_asked_for(asked):
    """A sleeping top has no psi and phi at all; it divides nothing by nothing."""
    scene = polhode.load("lagrange/sleeping-stable").at([Fraction(k, 8) for k in range(COUNT)])
    columns = {"t": [float(t) for t in scene.times], "psi": [None] * COUNT, "theta": [0.0] * COUNT}
    found = polhode.compare(columns, scene)
    assert found.parts["angles"] > 15
    columns["theta"][700] = 1e-7
    assert 6.9 < polhode.compare(columns, scene).parts["angles"] < 7.1
    assert {*asked} == {FIRST_LOOK}


@pytest.mark.slow
def test_theta_is_judged_where_psi_is_no_number():
    scene = polhode.load("lagrange/from-the-pole").at([Fraction(k, 50) for k in range(450)])
    true = polhode.reference(scene).angles(scene.times, 17)
    assert true[0][0] is None
    table = np.array([[0.25 if x is None else float(x) for x in row] for row in true])
    found = judged(scene, table)
    assert found._held.many.angles is not None
    assert found.parts["angles"] > 13
    table[0, 1] += 1e-7
    assert 6.9 < judged(scene, table).parts["angles"] < 7.1


def test_pieces_are_spread_and_hold_each_row_once():
    given = [*range(0, 9000, 3)]
    pieces = [*score._spread(given)]
    assert sorted(k for piece in pieces for k in piece) == given
    assert len(pieces[0]) == 32
    assert all(max(piece) - min(piece) > 8000 for piece in pieces)
    assert [*score._spread([])] == []
