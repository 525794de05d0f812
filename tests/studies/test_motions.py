"""The notable motions of the accuracy study are what the page says of them."""

from fractions import Fraction

import numpy as np

import polhode
from polhode.equations.hodographs import path
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.studies.accuracy import figure, motions, page


def points(name, times):
    """The path of a notable motion's point, and the closed form."""
    notable = next(n for n in motions.NOTABLE if n.case == name)
    scene = polhode.load(name)
    exact = polhode.reference(scene)
    direction = notable.direction or scene.body.centre
    rows = path(exact.attitude(times, 20), direction, number_types.mp(20))
    return np.array([[float(x) for x in row] for row in rows]), exact


def test_hess_middle_axis_draws_a_loxodrome():
    """artanh of its sine of latitude grows evenly with its longitude, about the momentum."""
    times = [Fraction(k, 8) for k in range(60)]
    found, exact = points("hess/loxodrome", times)
    scene = exact.scene
    momentum = [m * w for m, w in zip(scene.body.moments, scene.omega, strict=True)]
    rows = path(exact.attitude(times[:1], 20), momentum, number_types.mp(20))
    pole = np.array([float(x) for x in rows[0]])
    pole /= np.linalg.norm(pole)
    assert abs(pole[2]) < 1e-15  # horizontal
    east = np.cross([0, 0, 1], pole)
    height = np.arctanh(found @ pole)
    longitude = np.unwrap(np.arctan2(found[:, 2], found @ east))
    slopes = np.diff(height) / np.diff(longitude)
    assert abs(longitude[-1] - longitude[0]) > 10
    assert 1e-16 < np.ptp(slopes) < 1e-9
    assert abs(slopes[0]) > 0.1


def test_grioli_centre_of_mass_goes_round_an_inclined_axis():
    found, _ = points("grioli/precession", [Fraction(k, 10) for k in range(63)])
    axis = np.cross(found[20] - found[0], found[40] - found[0])
    axis /= np.linalg.norm(axis)
    assert np.ptp(found @ axis) < 1e-13
    assert abs(axis[2]) < 0.99


def test_the_released_body_goes_back_the_way_it_came():
    scene = polhode.load("goryachev-chaplygin/released")
    half = exactly(polhode.reference(scene).period) / 2
    found, exact = points(scene.name, [half + s * Fraction(k) for k in (1, 3, 7) for s in (1, -1)])
    assert np.max(np.abs(found[::2] - found[1::2])) < 1e-14
    assert max(abs(float(x)) for x in exact.at([half], 20)[0][:3]) < 1e-15


def test_the_page_shows_them_where_the_results_have_them():
    rows = motions.paths()
    assert [len(row["path"]) for row in rows] == [motions.SAMPLES] * 3
    assert figure.motions(rows).startswith("<?xml")
    found = {"cases": [], "motions": rows}
    text = "".join(str(block) for block in page.blocks(found))
    assert all(row["seen"] in text for row in rows)
    assert "motions" not in "".join(str(b) for b in page.blocks({"cases": []}))
