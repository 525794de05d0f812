"""Kovalevskaya's top in balls: what must not be decided by luck, and questions that once failed."""

import time
from fractions import Fraction

import pytest
from flint import acb, arb

import polhode
from polhode.closed_forms.balls.core import Refused, TooFewBits
from polhode.closed_forms.balls.weierstrass import Quartic, Weierstrass, complex_functions
from polhode.closed_forms.kovalevskaya.theta import theta_attitude, theta_state
from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop
from polhode.numbers.exact import ONE
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.members import motion_table, read_start

F = Fraction
BODY, TORQUE = (F(2), F(2), F(1)), (F(1), F(0), F(0))
#: omega and gamma, one motion of each of the six types of the curve
GENERIC = {
    name: read_start(texts)[2:4] for name, texts in [*motion_table()["kovalevskaya"].items()][:6]
}
PSI = F(7, 10)


def top_of(omega, gamma):
    start = (tuple(map(F, row)) for row in (omega, gamma))
    return KovalevskayaTop(BODY, TORQUE, *start, PSI)


def test_of_two_places_that_fit_the_start_the_attitude_takes_neither():
    """The first was a wrong one in 14 of 1504 set-ups: more bits, until one is left."""
    top = top_of(*GENERIC["e-ee+"])
    with ctx.workprec(107):
        motion = top._solution().motion
        theta_attitude.ThetaAttitude(motion, top._first_turn())
        motion.choices.append(motion.choices[0])
        with pytest.raises(TooFewBits):
            theta_attitude.ThetaAttitude(motion, top._first_turn())


def test_a_gap_of_1e_28_to_a_degenerate_curve():
    """The nearest branch point by balls: doubles tie, and no number of bits helped."""
    turn = F(1, 10**28)
    scale = 1 + turn * turn
    gamma = (2 * turn / scale, F(0), -(1 - turn * turn) / scale)
    top = KovalevskayaTop(BODY, TORQUE, (F(25, 37), F(11, 37), F(-33, 37)), gamma)
    assert top.regime in GENERIC
    begin = time.process_time()
    top.at([F(3, 2)], 20)
    assert time.process_time() - begin < 5


@pytest.mark.slow
@pytest.mark.parametrize("t", [-(10**6)])
def test_neighbours_next_to_a_doubly_degenerate_curve(t):
    """Two pairs missed 15 digits by 1e-9: their own estimate saw x^2, and the error was x^4's."""
    start = (F(-10, 29), F(7, 10**16), F(29, 10)), (F(0), F(0), F(-1))
    top = KovalevskayaTop(BODY, TORQUE, *start, PSI)
    assert top.regime == "degenerate curve, quasi-periodic"
    rows, right = ([*top.at([F(t)], n)[0], *top.attitude([F(t)], n)[0]] for n in (15, 50))
    with mpmath.workdps(60):
        assert max(abs(a - b) for a, b in zip(rows, right, strict=True)) < mpf("3e-15")
    assert (top.proven, top.radii([F(t)], 15)) == (False, None)


def test_a_choice_is_dropped_only_where_it_is_proven_false(monkeypatch):
    """A choice that tells nothing asks for more bits; none that fits is a fault."""
    top = top_of(*GENERIC["e-ee+"])
    with ctx.workprec(107):
        monkeypatch.setattr(theta_state, "_MOST_CHOICES", 0)
        with pytest.raises(TooFewBits):
            top._solution()
        monkeypatch.undo()
        misses = theta_state.Quotients.misses
        monkeypatch.setattr(theta_state.Quotients, "misses", lambda *_: True)
        with pytest.raises(ArithmeticError, match="a fault"):
            top._solution()
        monkeypatch.setattr(theta_state.Quotients, "misses", misses)
        nan = acb(arb.nan())
        choice = theta_state.Quotients((nan, nan), [nan] * 3, [nan] * 3, [nan] * 3, [nan] * 3)
        with pytest.raises(TooFewBits):
            choice.misses([arb(0)] * 6, [(acb(1), acb(1))] * 7)


@pytest.mark.parametrize("name", ["e-ee+", "-e+ (complex pair)"])
def test_a_corrupted_constant_is_told(name, monkeypatch):
    """c wrong by 1e-25: an error, no answer."""
    honest = theta_attitude.ThetaAttitude._third_kind

    def corrupt(self):
        e, rate = honest(self)
        return e, rate + arb("1e-25")

    monkeypatch.setattr(theta_attitude.ThetaAttitude, "_third_kind", corrupt)
    with pytest.raises(ArithmeticError, match="a fault"):
        top_of(*GENERIC[name]).attitude([F(2)], 40)


def test_a_refusal_names_the_regime_and_how_far():
    top = top_of(("2/5", "1/5", "-8/5"), ("-9/25", "-12/25", "-4/5"))
    begin = time.process_time()
    with pytest.raises(Refused, match=r"asymptotic: this motion amplifies .*[\d.e+]+ radians"):
        top.at([F(10**6)], 5)
    assert time.process_time() - begin < 20


def test_attitude_of_a_periodic_motion_at_1e16():
    """Whole periods are counted exactly, and their turn is no angle."""
    top = top_of(("4/5", 0, "4/5"), ("-12/25", "3/5", "16/25"))
    far = [F(10) ** 16]
    one, other = top.attitude(far, 20)[0], top.attitude(far, 40)[0]
    with mpmath.workdps(50):
        assert max(abs(a - b) for a, b in zip(one, other, strict=True)) < mpf("1e-20")


@pytest.mark.parametrize("a", [(0, 1, 0, 0, -4), (1, 0, -1, 0, 2), (1, 0, 1, 0, 0)])
def test_weierstrass_function_solves_its_equation(a):
    """P'^2 = 4 P^3 - g2 P - g3, with P and P' from sn, cn, dn."""
    quartic = Quartic(tuple(ONE * x for x in a))
    g2, g3 = quartic.invariants
    with ctx.workprec(120):
        function = Weierstrass(quartic)
        for t in ("0.3", "1.1", "-2.9"):
            sn, cn, dn = complex_functions(function.functions, acb(function.rate * arb(t), 0.1))
            if function.paired:
                P = function.base + function.size * (1 + cn) / (1 - cn)
                slope = -2 * function.size * function.rate * sn * dn / ((1 - cn) * (1 - cn))
            else:
                P = function.base + function.size / (sn * sn)
                slope = -2 * function.size * function.rate * cn * dn / (sn * sn * sn)
            rest = slope * slope - 4 * P * P * P + arb(g2.numerator) / g2.denominator * P
            rest += arb(g3.numerator) / g3.denominator
            assert rest.contains(0)
            assert rest.real.rad() < abs(slope * slope) * arb(2) ** -80


@pytest.mark.slow
def test_neighbours_that_have_left_the_motion_tell_nothing():
    """They came near each other again: 20 digits agreed at t = 1000, and none was right."""
    top = polhode.reference("kovalevskaya/asymptotic")
    for digits in (3, 10, 15, 20):  # at each of which others agreed on something else
        with pytest.raises(polhode.BadInput, match="amplifies errors: no digits are known beyond"):
            top.at([1000], digits)
    (few,), (many,) = top.at([100], 15), top.at([100], 40)
    with mpmath.workdps(50):
        assert 1e-60 < max(abs(mpf(x) - mpf(y)) for x, y in zip(few, many, strict=True)) < 1e-15


@pytest.mark.slow
def test_neighbours_in_too_many_bits_are_refused():
    """The limit was 7000 bits for 200 digits, many minutes; 150 have to be there, and right."""
    top = polhode.reference("kovalevskaya/asymptotic")
    begin = time.process_time()
    with pytest.raises(polhode.BadInput, match=r"1000 bits give 1[6-9]\d of 300 digits"):
        top.at([1], 300)
    (few,), (many,) = top.at([1], 60), top.at([1], 150)
    assert time.process_time() - begin < 90
    with mpmath.workdps(160):
        assert 1e-110 < max(abs(x - y) for x, y in zip(few, many, strict=True)) < 1e-60


def test_of_a_separatrix_it_is_known_at_once_that_its_attitude_is_not_proven():
    """It was said only once the attitude had been asked for."""
    top = top_of((0, F(7, 5), 0), (F(-24, 25), 0, F(7, 25)))
    assert top.period(20) is None
    assert top.proven == "states are proven; the attitude is reproduced, by neighbours"
    swinging = top_of((0, F(6, 5), 0), (F(-24, 25), 0, F(7, 25)))
    assert swinging.period(20) is not None
    assert swinging.proven is True


@pytest.mark.slow
def test_neighbours_are_followed_on_either_side_whatever_is_asked_first():
    """Late, early, and back: the same numbers as from a top that was asked nothing else."""
    times = [F(40), F(3), F(-25), F(90), F(1, 7)]
    asked = polhode.reference("kovalevskaya/asymptotic")
    for t in times:
        alone = polhode.reference("kovalevskaya/asymptotic").at([t], 20)
        with mpmath.workdps(40):
            pairs = zip(asked.at([t], 20)[0], alone[0], strict=True)
            assert max(abs(mpf(x) - mpf(y)) for x, y in pairs) < 1e-20
