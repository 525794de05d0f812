"""Certificates of periodic orbits: what is proved stays so, and nothing false is."""

import copy
import json
import pathlib
from dataclasses import replace
from fractions import Fraction

import pytest
from flint import arb, ctx

import polhode
from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import by_checker
from polhode.dynamics.level_body import LevelBody
from polhode.proofs import orbit_certificate
from shared import proofs as chains
from shared.tools import altered, answer, tiers

KINDS = {"elliptic": chains.ELLIPTIC, "hyperbolic": chains.HYPERBOLIC}


@pytest.fixture(scope="module")
def orbits():
    return {kind: chains.proved(point) for kind, point in KINDS.items()}


@pytest.fixture(scope="module")
def small():
    """The certificate of an orbit with few digits."""
    return json.loads(chains.proved(chains.HYPERBOLIC, 12).certificate)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_proved_is_proved_by_the_file_alone(kind, orbits, tmp_path):
    path = tmp_path / "orbit.json"
    orbits[kind].save(path)
    verdict = polhode.verify(path)
    assert verdict.proved
    assert f"it is {kind} on its level" in verdict.text
    assert "of this body a periodic orbit" in verdict.text
    assert "least period lies within" in verdict.text
    assert str(orbits[kind].period)[:20] in verdict.text


BODIES = pathlib.Path(__file__).parents[1] / "data/orbit-of-bodies.json"
CORNER = [1, 1, 1, 1, 1, 1]


def test_a_certificate_of_all_bodies_within_a_tolerance_is_one_of_every_body_in_its_balls():
    """As 0.3 wrote it, of those within 1e-9; the orbit of one at a corner lies in its balls."""
    verdict = polhode.verify(BODIES)
    assert verdict.proved
    assert "of every body in the scene's balls a periodic orbit" in verdict.text
    certificate = json.loads(BODIES.read_text())
    balls = [*certificate["scene"]["moments"], *certificate["scene"]["centre"]]
    assert all(f"[{', '.join(map(json.dumps, ball))}]" in verdict.text for ball in balls)
    numbers = [Fraction(x) + side * Fraction(r) for (x, r), side in zip(balls, CORNER, strict=True)]
    body = polhode.Body.of_moments(numbers[:3], numbers[3:], 1)
    scene = replace(chains.near(chains.ELLIPTIC), body=body)
    orbit = polhode.prove_orbit(scene, scene, digits=12, h=chains.H, f=chains.F)
    offs = []
    for name in ("period", "residue"):
        middle, radius = map(Fraction, certificate["statement"][name])
        offs.append(abs(getattr(orbit, name).centre - middle) / radius)
    assert 0.001 < max(offs) <= 1


@pytest.mark.parametrize("place", ["statement period", "statement residue", "statement start 1"])
def test_what_is_false_of_such_bodies_is_refused(place):
    certificate = json.loads(BODIES.read_text())
    assert MOVED in answer(altered(certificate, place, off))
    assert "nothing else" in answer(certificate | {"tolerance": "1e-9"})


def off(ball, by=2):
    """A ball moved by some of its radii."""
    return [str(Fraction(ball[0]) + Fraction(by) * Fraction(ball[1])), ball[1]]


def less_off(ball):
    """So that it holds the middle of what is proved, and not all of it."""
    return off(ball, "0.7")


def more(x):
    """A number larger by one part in 10^8, of balls of 10^-12."""
    return str(Fraction(x) * Fraction(10**8 + 1, 10**8))


MOVED, NEARER = "is not shown to lie in its ball", "no other orbit is so near"
#: A place of the certificate, what stands there then or is made of it, and what is said.
FALSE = [
    ("statement start 0", off, MOVED),
    ("statement start 4", off, MOVED),
    ("statement period", off, MOVED),
    ("statement residue", off, MOVED),
    ("statement start 0", less_off, MOVED),
    ("statement residue", less_off, MOVED),
    *((f"scene {key} 1", more, "refused") for key in ("moments", "centre", "level")),
    ("scene weight", more, "refused"),
    ("scene", {}, "expected the keys"),
    ("statement kind", "elliptic", "that the orbit is elliptic"),
    ("statement kind", "inverse hyperbolic", "that the orbit is inverse hyperbolic"),
    ("statement kind", "stable", "kind: expected hyperbolic"),
    *(("statement alone " + k, "1e-4", NEARER) for k in "012"),
    ("statement alone 2", "-1e-40", "no negative"),
    ("statement least", 1, "true or false"),
    ("statement start", [], "a list of 6"),
    ("statement", [], "expected the keys"),
    ("radius_bits", 5, "the condition of the step"),
    ("radius_bits", 160, "Krawczyk's test"),
    ("radius_bits", 10**9, "radius_bits"),
    ("divided_to", 2, "was not looked at"),
    ("divided_to", 10**9, "divided_to"),
]


@pytest.mark.parametrize(("place", "value", "said"), tiers(FALSE[:8], FALSE[8:]))
def test_what_is_false_is_refused_and_why(place, value, said, small):
    text = answer(altered(small, place, value))
    assert text.startswith("refused")
    assert said in text


def test_a_bound_is_told_on_its_right_side(small):
    wide = altered(small, "statement alone", ["1.09e-300", "9.99e-40", "1e-50"])
    for place, radius in (("start 2", "1.01e-7"), ("period", "1/3"), ("residue", "9.91")):
        wide = altered(wide, f"statement {place} 1", radius)
    text = answer(wide)
    assert "passes within 1.1e-07, in each component" in text
    assert "least period lies within 3.4e-01 of" in text
    assert "a residue within 1.0e+01 of" in text
    assert "no other orbit of the level passes within 1.0e-300 (omega) and 9.9e-40" in text
    assert "(gamma) of the point where this one does and has" in text
    assert "a period within 1.0e-50 of this one" in text


@pytest.mark.parametrize("column", [1, 7])
def test_an_end_that_is_not_known_well_proves_nothing(small, monkeypatch, column):
    """The box of the starts at its end, which the period's column is of, or one column of D."""
    closed = verify._closed

    def wide(run, end, *rest):
        by = arb(0, "1e-2" if column == 1 else 1)
        rows = [[y + by if k == column else y for k, y in enumerate(row)] for row in end]
        return closed(run, rows, *rest)

    monkeypatch.setattr(verify, "_closed", wide)
    assert answer(small).startswith("refused")


SMALL = Fraction(1, 10**22)  # of a box


@pytest.mark.slow
def test_three_periods_are_not_the_least_one(orbits):
    orbit = orbits["elliptic"]
    start = [x.centre for x in (*orbit.omega, *orbit.gamma)]
    period = 3 * orbit.period.centre
    on = LevelBody(orbit.scene, orbit.h, orbit.f)
    guesses = orbit_certificate.guesses(on, start, period, SMALL, 140, 0.2)
    zero = by_checker(verify.zero_near, guesses)
    assert zero.repeated == "the period may be 3 times the least one"
    statement = json.loads(orbit.certificate)["statement"]
    claim = verify.read_orbit(statement)._replace(
        period=(period, Fraction(1, 10**20)), residue=(Fraction(0), Fraction(10**9)), alone=[0] * 3
    )
    kind = next(kind for kind, test in verify.STABILITY.items() if test(zero.residue) is True)
    claim = claim._replace(kind=kind, start=[(x, Fraction(1, 10**20)) for x in start])
    with ctx.workprec(400):
        with pytest.raises(verify.NotProved, match="may be 3 times the least one"):
            verify.check_orbit(claim, zero)
        verify.check_orbit(claim._replace(least=False), zero)


@pytest.mark.slow
def test_the_box_and_not_its_centre_is_followed_to_a_part_of_the_period():
    """The centre is off by a part of the box, along the direction that grows."""
    orbit, radius = chains.proved(chains.HYPERBOLIC), Fraction(1, 10**22)
    grown = map(Fraction, chains.guess()[1].saddle.unstable.tolist())
    balls = zip((*orbit.omega, *orbit.gamma), grown, strict=True)
    start = [x.centre + Fraction(3, 10) * radius * y for x, y in balls]
    level = LevelBody(orbit.scene, orbit.h, orbit.f)
    guesses = orbit_certificate.guesses(level, start, 4 * orbit.period.centre, radius, 140, 0.2)
    zero = by_checker(verify.zero_near, guesses)
    assert zero.repeated == "the period may be 2 times the least one"


SHIFT = 1  # the checker's unit of time is 2^-SHIFT


def derivative_of(small, bits, monkeypatch, corner=None, later=0, point=False):
    """DF(Y) for a box of radius 2^-bits; of a start at a corner of it, and a later end.

    ``point``: one start, though the end is not known but for 4 2^-bits.
    """
    changed = copy.deepcopy(small) | {"radius_bits": bits if corner is None else 100, "bits": 200}
    if corner is not None:
        sizes = [2.0 ** (SHIFT - bits)] * 3 + [2.0**-bits] * 3
        power, fine = Fraction(2) ** -changed["state_bits"], changed["time_bits"]
        start = zip(changed["centres"][0], corner, map(Fraction, sizes), strict=True)
        period = changed["grid"][-1] * Fraction(2) ** -fine
        ctx.prec = 200
        at = [verify.ball((x * power + sign * size, Fraction(0))) for x, sign, size in start]
        changed |= certificate_file.steps(changed["scene"], at, period, 200, fine, 0.15)._asdict()
        ctx.prec = 53
    if later:
        changed["grid"][-1] += later * (1 << (changed["time_bits"] + 2 - bits - SHIFT))
    matrices, honest = [], verify.derivative_of_f

    def derivative_of_f(run, *arguments):
        assert run.shift == SHIFT
        df, reached = honest(run, *arguments)
        matrices.append(df)
        return df, reached

    begin, first = verify.Set.__init__, [point]

    def started(self, m, box, states):
        small = [[arb(0)] * 8] * 6 if first.pop() else box
        first.append(False)
        begin(self, m, small, states)

    with monkeypatch.context() as patch:
        patch.setattr(verify, "derivative_of_f", derivative_of_f)
        patch.setattr(verify.Set, "__init__", started)
        answer(changed)
    return matrices[0]


@pytest.mark.slow
@pytest.mark.parametrize(("point", "later"), [(True, 1), (False, 0)])
def test_the_derivative_holds_those_of_the_corners(point, later, small, monkeypatch):
    """DF(Y) of a fat box beside DF at its corners, or of a point and a later end."""
    corner = (0,) * 6 if point else (1, -1, 1, 1, -1, 1)
    truth = derivative_of(small, 20, monkeypatch, corner, later)
    claimed = derivative_of(small, 20, monkeypatch, point=point)
    for i in range(10):
        for j in range(7):
            assert i == 6 or claimed[i, j].overlaps(truth[i, j])  # the guesses W and a differ


@pytest.mark.slow
def test_a_transition_that_is_bent_is_contained(small, monkeypatch):
    """D by another V: the same but for a wider ball."""
    exact = derivative_of(small, 100, monkeypatch)
    honest = verify.next_of_v

    def bent(total, k):
        return (honest(total, k) * arb("1.0001" if k == 0 else 1)).mid()

    monkeypatch.setattr(verify, "next_of_v", bent)
    wider = derivative_of(small, 100, monkeypatch)
    assert all(wider[i, j].overlaps(exact[i, j]) for i in range(6) for j in range(6))


def test_dependent_gradients_are_refused(small, monkeypatch):
    """Where W no longer tells the integrals apart, a zero of F need not be periodic."""
    closed = verify.gradients

    def dependent(run, x):
        rows = closed(run, x)
        wide = max(float(y.rad()) for y in x) > 0
        return [rows[0], rows[0], rows[2]] if wide and float(x[0].rad()) > small_r else rows

    small_r = 2.0 ** -small["radius_bits"] * 4
    monkeypatch.setattr(verify, "gradients", dependent)
    assert "may be dependent" in answer(small)


@pytest.fixture
def closing(small, monkeypatch):
    """What the theorem at the period's end is given: the run, columns, period, r, the level."""
    calls, honest = [], verify._closed

    def closed(*arguments):
        calls.append(arguments)
        return honest(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(verify, "_closed", closed)
        assert not answer(small).startswith("refused")
    with ctx.workprec(200):
        yield calls[0]


def test_a_period_within_its_box_of_0_proves_nothing(closing):
    run, end, _, r, values = closing
    with pytest.raises(verify.NotProved, match="no longer than its box"):
        verify._closed(run, end, 3 * r, r, values)
    verify._closed(run, end, 5 * r, r, values)


def test_a_plane_that_may_touch_the_motion_proves_nothing(closing, monkeypatch):
    *_, r, _ = closing
    rates, least = verify.rates, float(r) / 4

    def wider(body, box):
        is_box = least < float(box[0].rad()) < 1.5 * float(r)
        return [y + arb(0, 100 * is_box) for y in rates(body, box)]

    monkeypatch.setattr(verify, "rates", wider)
    with pytest.raises(verify.NotProved, match="the plane of the start may touch"):
        verify._closed(*closing)


def test_how_far_an_orbit_is_alone_is_less_by_slope_and_distance(closing):
    """Of a level that is off by a part of the box, so that the zero is away from the centre."""
    run, end, period, r, values = closing
    values = [values[0] + r / 30, *values[1:]]
    zero, _ = verify._closed(run, end, period, r, values)
    x, box = run.centres[0], float(r)
    f = [float(y) for y in verify.rates(run.body, x)]
    slope = max(map(abs, f)) * sum(map(abs, f)) / sum(y * y for y in f)
    away = [float(abs(y * u - z).upper()) for y, u, z in zip(zero.start, run.rates, x, strict=True)]
    unit = float(run.rates[0])
    later = float(abs(zero.period / run.rates[0] - period).upper())
    assert max(away) > 0.01 * box / (1 + slope)
    assert later > 0.001 * box
    expected = box / (1 + slope) - max(away)
    omega, gamma, time = map(float, zero.alone)
    assert gamma == pytest.approx(expected, rel=1e-3, abs=0)
    assert omega == pytest.approx(expected / unit, rel=1e-3, abs=0)
    assert time == pytest.approx((4 * box - later) * unit, rel=1e-5, abs=0)


def test_a_part_of_the_period_ends_outside_of_the_box_at_every_time(closing):
    """It differs from the start by more than the box, and what its end may be later, or less."""
    run, _, _, r, _ = closing
    x = run.centres[0]
    reach = arb(verify.around(run.body, x, 2 * r)[0].rad())  # of half a period, known to 2 r
    for more, said in (("0.5", "the period may be 2 times the least one"), (2, "")):
        back = {2: [y + reach + arb(more) * r for y in x]}
        assert verify._repeated(run, r, back, arb("1.5")) == said
