"""One orbit of every body within a tolerance: its balls hold what corners of the bodies give."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import BadInput, NotProved
from polhode.cli import main
from polhode.enclosures import fixed_point_problem, step_bound
from polhode.numbers.flint_context import ctx
from polhode.proofs import level as levels
from polhode.proofs.prove_orbit import prove_found, prove_orbit
from shared import orbit_newton
from shared import orbit_proofs as proofs
from shared.mutation import without

TOLERANCE = Fraction(1, 10**6)
THIN = 90
SHORT = Fraction(1, 4096)
CORNERS = [(1, 1, 1, 1, 1, 1), (-1, 1, -1, 1, -1, 1), (1, -1, 1, 1, 1, -1)]


def body(corner, tolerance=TOLERANCE):
    """Moments and torque at a corner of the tolerance."""
    numbers = [*proofs.MOMENTS, *proofs.TORQUE]
    moved = [x * (1 + side * tolerance) for x, side in zip(numbers, corner, strict=True)]
    return moved[:3], moved[3:]


def worst(corner, seconds=None):
    """The largest |truth - middle|/radius: of the state, DF and H at the end, for one body.

    ``seconds``: the end instead of the period; the less there is, the less the set hides.
    """
    on = proofs.level()
    on = replace(on, motion=replace(on.motion, tolerance=TOLERANCE))
    made = replace(proofs.sharp(proofs.ELLIPTIC), bits=THIN)
    if seconds is not None:
        made = replace(made, period=int(seconds * 2**122))
    tube, slope = proofs.followed(made, on, THIN)
    x = [Fraction(n, 1 << 122) for n in made.start]
    time = Fraction(made.period, 1 << 122)
    end = orbit_newton.flow(*body(corner), x, time)
    d = orbit_newton.derivative(*body(corner), x, time)
    speed = orbit_newton.rates(*body(corner), end)
    pairs = [(d[i][j] - (i == j), slope[i][j]) for i in range(6) for j in range(6)]
    pairs += [(speed[i], slope[i][6]) for i in range(6)]
    found = [ratio(value, *ball) for value, ball in pairs]
    with ctx.workprec(300):
        found += [proofs_ratio(y, z) for y, z in zip(end, tube.rows[-1], strict=True)]
        known = on.balls(210)
        m, k = ([a / 2 for a in v] for v in body(corner))  # over the largest moment
        w, g = x[:3], x[3:]
        h = sum(a * b * b for a, b in zip(m, w, strict=True))
        h += 2 * sum(a * b for a, b in zip(k, g, strict=True))
        point = [levels.arb((n, -122)) for n in made.start]
        found.append(proofs_ratio(h, known.integrals(point)[0]))
    return max(found)


def proofs_ratio(value, ball):
    return ratio(value, proofs.middle_of(ball), proofs.middle_of(ball.rad()))


def ratio(value, middle, radius):
    # finite differences are right to about thirty digits
    off = max(Fraction(0), abs(value - middle) - Fraction(1, 10**26))
    return float(off / radius) if radius else math.inf if off else 0.0


@pytest.mark.slow
@pytest.mark.parametrize("corner", CORNERS)
def test_state_derivative_and_energy_of_a_corner_lie_in_their_balls(corner):
    for seconds in (None, SHORT):
        assert 0.1 < worst(corner, seconds) <= 1 + 1e-9  # at one corner H is as far as its ball


#: What holds the other bodies, and how it is dropped.
DROPPED = {
    "the constants of the defect": (
        fixed_point_problem,
        "_whole",
        "slack[k] = upper(abs(balls[k] - ball(x, 4 * noise + 64)) * arb((1, noise)))",
        "pass",
    ),
    "the constants of the derivative": (
        step_bound,
        "_jacobian_gaps",
        "max(problem.factor_slack)",
        "1e-17",
    ),
    "the body of the level": (levels, "Level.balls", "what.spread(x)", "x"),
    "the field of the level": (
        levels,
        "Level.balls",
        "what.balls(bits)",
        "[ball(x, bits + 64) for x in what.constants]",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("part", DROPPED)
def test_a_dropped_part_is_noticed(part):
    with without(*DROPPED[part]):
        assert max(worst(corner, SHORT) for corner in CORNERS) > 1.001


@pytest.fixture(scope="module")
def found():
    return polhode.orbit_search("general/asymmetric-chaotic", grid=(8, 8), crossings=2)


@pytest.mark.sample(1)
@pytest.mark.parametrize("k", [0, 1])
def test_periods_and_residues_of_corners_lie_in_the_balls(found, k):
    tolerance = Fraction(1, 10**9)
    wide = prove_found(found, k, 15, tolerance=tolerance)
    assert "for every body whose moments" in str(wide)
    exact = prove_found(found, k, 15)
    offs = []
    for corner in [*CORNERS, *([-x for x in corner] for corner in CORNERS)]:
        moments, torque = body(corner, tolerance)
        scene = polhode.top(
            moments=moments,
            centre=torque,
            weight=1,
            omega=[x.centre for x in exact.omega],
            gamma=[x.centre for x in exact.gamma],
            normalise=True,
            end=exact.period.centre,
        )
        other = prove_orbit(scene, orbit=scene, digits=15, h=wide.h, f=wide.f)
        assert other.kind == wide.kind
        for x, y in ((other.period, wide.period), (other.residue, wide.residue)):
            offs.append(abs(x.centre - y.centre) / Fraction(y.radius))
    assert 0.001 < max(offs) <= 1


@pytest.mark.slow
def test_a_tolerance_that_is_too_wide_names_one_that_works(found):
    with pytest.raises(
        NotProved, match=r"within 1e-06 \(.*\): the largest power of 10 .* is 1e-09"
    ):
        prove_found(found, 1, 15, tolerance=TOLERANCE)
    assert prove_found(found, 1, 15, tolerance=Fraction(1, 10**9)).kind == "hyperbolic"


@pytest.mark.parametrize("given", ["0", "1", "-1e-9", "x", "nan"])
def test_what_is_no_tolerance_is_one_line(given, capsys):
    assert main(["prove", "orbit", "general/asymmetric-chaotic", f"--tolerance={given}"]) == 2
    assert "tolerance = " in capsys.readouterr().err


def test_no_certificate_tells_of_many_bodies(found, tmp_path, capsys):
    wide = prove_found(found, 0, 15, tolerance=Fraction(1, 10**8))
    with pytest.raises(BadInput, match="one body"):
        wide.save(tmp_path / "orbit.json")
    path = str(tmp_path / "orbit.json")
    asked = ["prove", "orbit", "general/asymmetric-chaotic", "--tolerance", "1e-9", "-o", path]
    assert main(asked) == 2
    assert "one body" in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]
