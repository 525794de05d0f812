"""Certificates of stability: what is proved stays so, nothing false is, each fault is noticed."""

import cmath
import json
import random
from fractions import Fraction
from pathlib import Path

import pytest
from flint import acb, arb

from polhode.certificates import verify
from polhode.numbers.flint_context import ctx
from shared.proofs import certificate, stability
from shared.tools import altered, answer, leaves, of_table, tiers

STORED = Path(__file__).parents[2] / "cases" / "certificates"


@pytest.fixture(scope="module")
def stored():
    return certificate()


@pytest.fixture(scope="module")
def flow():
    """Where the jets of the orbit are after each step."""
    steps, honest = [], verify.jet_step
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verify, "jet_step", lambda *x: steps.append(honest(*x)) or steps[-1])
        text = answer(certificate())
    assert "it is elliptic on its level" in text
    assert "it is stable for all time, forward and back" in text
    assert "of -0.36800654953258" in text
    return steps


@pytest.fixture
def computed(flow, monkeypatch):
    """The flow's jets are not computed again."""
    rest = iter(flow * 10)
    monkeypatch.setattr(verify, "jet_step", lambda *_: next(rest))


# -- what is false, or no certificate -------------------------------------------------------------


def off(ball):
    """A ball moved by two of its radii."""
    return [str(Fraction(ball[0]) + 2 * Fraction(ball[1])), ball[1]]


def opposite(ball):
    return [str(-Fraction(ball[0])), ball[1]]


MOVED = "is not shown to lie in its ball"
#: A place of the certificate, what stands there then or is made of it, and what is said.
FALSE = [
    ("statement twist", off, f"the twist {MOVED}"),
    ("statement twist", opposite, f"the twist {MOVED}"),
    ("statement twist", lambda ball: ball[0], f"the twist {MOVED}"),
    ("statement twist", ["0", "10"], "the stated twist may be 0"),
    ("statement rotation", off, f"the rotation {MOVED}"),
    ("statement rotation", lambda x: [str(1 - Fraction(x[0])), x[1]], f"the rotation {MOVED}"),
    ("statement kind", "hyperbolic", "statement.kind: expected elliptic"),
    ("statement kind", "stable", "statement.kind: expected hyperbolic or"),
    ("statement residue", off, "the residue is not shown"),
    ("kind", "orbit", "the certificate: expected the keys"),
    ("jet_bits", 31, "jet_bits: expected a whole number from 32 to 4000"),
    ("jet_bits", 10**9, "jet_bits: expected a whole number from 32 to 4000"),
    ("weight_bits", -1, "weight_bits: expected a whole number from 0 to 200"),
    ("weight_bits", 201, "weight_bits: expected a whole number from 0 to 200"),
    ("weight_bits", "10", "weight_bits: expected a whole number from 0 to 200"),
    ("grid", 3, "grid: expected a list"),
]


@pytest.mark.parametrize(("place", "value", "said"), FALSE)
def test_what_is_false_is_refused_and_why(place, value, said, stored, computed):
    text = answer(altered(stored, place, value))
    assert text.startswith("refused")
    assert said in text


def test_keys_are_those_of_the_statement_and_no_others(stored):
    said = (
        "statement: expected the keys kind, start, period, residue, least, alone, rotation, twist"
    )
    more, less = (altered(stored, "statement", dict) for _ in range(2))
    more["statement"]["stable"] = True
    del less["statement"]["twist"]
    assert said in answer(more)
    assert said in answer(less)
    assert "the certificate: expected the keys" in answer({**stored, "stable": True})


#: Guesses, and what is said with them: anything true, or nothing.
GUESSES = [
    ({"jet_bits": 40}, "refused"),
    ({"jet_bits": 110}, "it is stable"),
    ({"weight_bits": 0}, "jets, step 1 of"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("change", "said"), GUESSES)
def test_guesses_prove_nothing_false(change, said, stored):
    assert said in answer(stored | change)


def test_a_hyperbolic_orbit_is_refused_before_any_jet(monkeypatch):
    monkeypatch.setattr(verify, "twist_of", None)
    document = json.loads((STORED / "hyperbolic.json").read_text())
    document |= {"kind": "stability", "jet_bits": 96, "weight_bits": 10}
    document["statement"] |= {"kind": "elliptic", "rotation": [".1", "1"], "twist": ["1", ".5"]}
    assert "that the orbit is elliptic" in answer(document)


def test_a_long_computation_is_refused_before_it_begins(stored):
    steps = 200_000
    document = stored | {"jet_bits": 3000, "grid": [*range(steps + 1)]}
    assert "steps and states at 3000 bits are too many" in answer(document)
    assert "steps and states at 4000 bits are too many" in answer(stored | {"jet_bits": 4000})


CHANGES = {
    "1e-9": lambda x: str(Fraction(x) * (1 + Fraction(1, 10**9))),
    "sign": lambda x: str(-Fraction(x)),
    "0": lambda x: "0",
}


@pytest.mark.parametrize("change", of_table(CHANGES, "1e-9"))
def test_another_scene_is_not_proved_by_these_guesses(change, stored):
    """None of them is refused late, either: a periodic orbit has to be near all the same."""
    for place in (" ".join(map(str, at)) for at in leaves(stored["scene"], ("scene",))):
        document = altered(stored, place, lambda x: CHANGES[change](x))
        if Fraction(held_at(document, place)) != Fraction(held_at(stored, place)):
            assert answer(document).startswith("refused"), place


def held_at(value, place):
    for key in place.split():
        value = value[int(key) if key.isdigit() else key]
    return value


@pytest.mark.parametrize("count", tiers([], [3]))
def test_drawn_changes_of_a_certificate_prove_nothing_false(stored, count):
    """Numbers changed as chance has it: refused, or the statement is true."""
    chance = random.Random(65)
    paths = [at for at in leaves(stored) if at[0] not in ("format", "kind")]
    truth = stability()
    for _ in range(count):
        place = " ".join(map(str, chance.choice(paths)))
        document = altered(stored, place, lambda x: drawn(x, chance))
        text = answer(document)
        if not text.startswith("refused"):
            assert document["scene"] == stored["scene"], place
            for name in ("rotation", "twist"):
                middle, radius = map(Fraction, document["statement"][name])
                assert abs(middle - getattr(truth, name).centre) <= radius + Fraction(1, 10**9)


def drawn(x, chance):
    if isinstance(x, bool) or not isinstance(x, (int, str)):
        return not x
    if isinstance(x, int):
        return chance.choice([x + 1, -x, 0, 2, x + chance.randrange(1 << 40), x * 3 // 2])
    try:
        value = Fraction(x)
    except ValueError:
        return "2"
    return str(chance.choice([-value, value * 2, 0, 2, value + Fraction(1, 10**9), value / 3]))


# -- a start and a period that are known badly ----------------------------------------------------


@pytest.fixture(scope="module")
def zero(stored):
    with ctx.workprec(64):
        return verify.zero_near(stored)


def twist_of(zero):
    with ctx.workprec(64):
        return verify.twist_of(zero, verify.Guide(96, 10))


class Begun(Exception):
    """The first step of jets, which is not made."""


def test_a_start_that_is_known_badly_is_followed_whole(zero, monkeypatch):
    with ctx.workprec(200):
        wide = zero._replace(start=[x + arb(0, "1e-18") for x in zero.start])

    def first_step(body, centre, eps, time, norm, bits):
        raise Begun(norm.around(centre, eps))

    monkeypatch.setattr(verify, "jet_step", first_step)
    with pytest.raises(Begun) as first:
        twist_of(wide)
    pairs = zip(wide.start, wide.run.rates, first.value.args[0], strict=True)
    with ctx.workprec(200):
        assert all(row.parts[0].contains(x * rate) for x, rate, row in pairs)


@pytest.mark.slow
def test_the_last_step_ends_in_all_of_the_period_s_ball(zero):
    with ctx.workprec(200):
        period = zero.period + arb("1e-10") + arb(0, "2e-10")
        twist = twist_of(zero._replace(period=period))
        assert float(twist.rotation.rad()) < 1e-5
        for name in ("rotation", "twist"):
            ball = getattr(stability(), name)
            truth = arb(str(float(ball)), ball.radius + 1e-15)
            assert getattr(twist, name).contains(truth), name


def test_a_last_step_that_may_be_none_proves_nothing(zero, monkeypatch):
    run = zero.run
    with ctx.workprec(200):
        before = verify.dyadic(run.grid[-2], -run.time_bits)
        period = before + arb(0, "1e-9")
    monkeypatch.setattr(verify, "jet_step", lambda *x: ([*x[1]], x[2]))
    with pytest.raises(verify.NotProved, match="no longer than the period's ball"):
        twist_of(zero._replace(period=period))


# -- the normal form ------------------------------------------------------------------------------


def map_of(beta, delta, mu=1j, bend=0, radius=1e-13):
    """w -> mu (w + i beta |w|^2 w + delta w*^3), w = (X + i Y)/sqrt 2, in X and Y + bend X^2."""
    with ctx.workprec(64):
        half = acb(arb("0.5").sqrt())
        x, y = verify.jet(acb(0), acb(1)), verify.jet(acb(0), acb(0), acb(1))
        y = y - x * x * acb(bend)
        w, bar = (x + y * acb(0, 1)) * half, (x - y * acb(0, 1)) * half
        image = w + w * w * bar * acb(0, beta) + bar * bar * bar * acb(delta)
        image = image * (acb(mu) / half)
        x, y = (verify.Jet(map(part, image.parts)) for part in (lambda z: z.real, lambda z: z.imag))
        y = y + x * x * arb(bend)
        return [[part + arb(0, radius) for part in row.parts] for row in (x, y)]


@pytest.mark.parametrize(
    ("beta", "delta", "bend"), [(1, 0.98, 0), (-1, 0.58 + 0.78j, 1), (2, 0, 1)]
)
def test_a_resonance_of_the_fourth_order_whose_term_is_small_leaves_the_twist(beta, delta, bend):
    mu, q, twist = verify.normal_form(map_of(beta, delta, bend=bend))
    size = 2 * abs(float((q[0] * q[1].conjugate()).imag))
    assert float(twist.mid()) / size == pytest.approx(beta, rel=1e-9)
    assert float(mu.real.mid()) == pytest.approx(0, abs=1e-12)


FOURTH = "the residue may be 1/2: a resonance of the fourth order, of which a term is large"
THIRD = cmath.exp(2j * cmath.pi / 3)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"beta": 1, "delta": 1.02}, FOURTH),
        ({"beta": 0.5, "delta": 0.31 + 0.41j, "bend": 1}, FOURTH),
        ({"beta": 0, "delta": 0.1, "bend": 1}, FOURTH),
        ({"beta": 1, "delta": 0, "mu": THIRD}, "a resonance of the third order"),
        ({"beta": 1, "delta": 0, "mu": THIRD * (1 + 1e-14j)}, "a resonance of the third order"),
        ({"beta": 1, "delta": 0, "mu": 1.001j}, "preserves no area"),
    ],
)
def test_a_map_whose_twist_says_nothing_is_refused(numbers, said):
    with pytest.raises(verify.NotProved, match=said):
        verify.normal_form(map_of(**numbers))
    beside = {"mu": cmath.exp(1j * (2 * cmath.pi / 3 + 1e-6)), "delta": 0}
    verify.normal_form(map_of(**numbers | beside))


@pytest.mark.parametrize("angle", [0.7, 2.0])
def test_the_twist_of_henon_s_map_is_the_known_one(angle):
    """x' = x c - (y - x^2) s, y' = x s + (y - x^2) c, in which |z|^2 = 2 J."""
    with ctx.workprec(200):
        c, s, zero = arb(angle).cos(), arb(angle).sin(), arb(0)
        rows = [[zero, c, -s, s, *[zero] * 6], [zero, s, c, -c, *[zero] * 6]]
        assert verify.MONOMIALS[1:4] == [(1, 0), (0, 1), (2, 0)]
        _, q, beta = verify.normal_form(rows)
        twist = beta / (2 * abs((q[0] * q[1].conjugate()).imag))
        closed_form = -(3 * (arb(angle) / 2).cot() + (3 * arb(angle) / 2).cot()) / 8
        assert abs(twist - closed_form) < arb(10) ** -50
