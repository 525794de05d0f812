"""The loop over precisions, frames, angles and Jacobi's functions in balls."""

from fractions import Fraction

import pytest
from flint import arb

from polhode.closed_forms.balls import core
from polhode.closed_forms.balls.core import Refused, TooFewBits, ball, sure_rows, until_sure
from polhode.closed_forms.balls.jacobi import Jacobi, Shift
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf, mpmath

F = Fraction
ONE = [arb(1)]


def test_digits_that_a_difference_loses_are_made_up_for():
    """sqrt(1 + x) - 1 of x = 1e-60, to 30 digits of itself."""
    x = F(1, 10**60)
    precisions = []

    def row():
        precisions.append(ctx.prec)
        excess = ball(1 + x).sqrt() - 1
        return [excess], [ball(x)]

    (excess,) = until_sure(row, 30)
    with ctx.workprec(600):
        assert abs(excess - (ball(x) / 2 - ball(x * x) / 8)) < arb(10) ** -89
    assert precisions[0] < 200 < precisions[-1] < 800


def refused():
    raise Refused("the place has no such number")


#: The largest of [1, not a number] is 1: each number is asked, and each size.
NOT_SURE = {
    "a number that is none": (lambda: ([arb(1), arb.nan()], ONE * 2), "give 0 of 20 digits"),
    "a size that may be 0": (lambda: ([arb(1)], [arb(0, 1)]), "give 0 of 20 digits"),
    "a size of 0": (lambda: ([arb(1)], [arb(0)]), "give 0 of 20 digits"),
    "an infinite number": (lambda: ([arb.pos_inf()], ONE), "give 0 of 20 digits"),
    "some digits": (lambda: ([arb(1, "1e-4")], ONE), "give 3 of 20 digits"),
    "a reason of its own": (refused, "the place has no such number"),
}


def test_what_is_not_sure_is_refused_and_a_fault_of_the_code_is_one():
    for row, words in NOT_SURE.values():
        with pytest.raises(Refused, match=words):
            until_sure(row, 20)
    for fault in (ValueError, ZeroDivisionError, OverflowError, TypeError):

        def row(fault=fault):
            raise fault

        with pytest.raises(fault):
            until_sure(row, 20)


@pytest.mark.parametrize(
    ("fault", "most", "precisions"),
    [(TooFewBits, 1000, [106, 212, 424, 848, 1000]), (Refused, None, [106])],
)
def test_too_few_bits_are_doubled_up_to_the_cap_and_a_reason_is_told_at_once(
    fault, most, precisions
):
    calls = []

    def row():
        calls.append(ctx.prec)
        raise fault

    with pytest.raises(Refused, match="1000 bits give 0 of 20 digits" if most else None):
        until_sure(row, 20, most)
    assert calls == precisions


def test_rows_that_are_sure_are_not_made_again_and_each_is_held_against_its_own_sizes():
    powers = []

    def row(t):
        powers.append(int(t.unique_fmpz()))
        return [(t * arb.pi()).sin()], ONE

    times = [F(10) ** k for k in range(0, 60, 10)]
    rows = sure_rows(row, times, 20)
    assert len(rows) == len(times)
    assert len(powers) <= len(times) + 6
    small = arb(10) ** -20
    first, second = sure_rows(
        lambda t: ([arb.pi()], [small if t > 0 else arb(1)]), [F(0), F(1)], 20
    )
    assert second[0].rad() < small * arb(10) ** -20 < first[0].rad() < arb(10) ** -20


def test_numbers_come_out_rounded_and_of_noise_only_its_size():
    with mpmath.workdps(40), ctx.workprec(200):
        third = core.number(arb(1) / 3, 20)
        assert mpf(10) ** -25 < abs(third - mpf(1) / 3) < mpf(10) ** -20
        noise = arb("1e-30", "1e-29")
        assert core.number(noise, 20)._mpf_[3] <= 8
        assert mpf("1.1e-29") > core.error_of(noise, 20) > mpf("1e-29")
        assert core.number(arb(0), 20) == 0 == core.error_of(arb(0), 20)
        large = core.number(arb(10) ** 20 / 3, 20, absolute=True)
        assert abs(large - mpf(10) ** 20 / 3) < mpf(10) ** -20
    x = exact.sqrt(F(2)) * exact.sqrt(F(3)) - exact.sqrt(F(6))  # 0 by the rule
    assert ball(x).is_zero()
    assert not core.enclosed(x).is_zero()
    assert core.enclosed(x).contains(0)


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("k2", [F(1, 10**20), F(2, 5), F(999, 1000)])
def test_quotients_keep_to_the_right_half_plane(k2, half):
    """For |a| < K', where their principal argument is continuous."""
    with ctx.workprec(200):
        functions = Jacobi(ball(k2), ball(1 - k2))
        K_of_complement = Jacobi(ball(1 - k2), ball(k2)).K
        for part in (F(-999, 1000), F(1, 5), F(1, 2), F(99, 100)):
            shift = Shift(functions, ball(part) * K_of_complement, half)
            for n in range(-20, 21):
                v = functions.K * n / 20
                assert shift.at(functions.at(v)).real > 0


@pytest.mark.parametrize("k2", ["1e-20", "0.3", "0.8", "0.99999"])
@pytest.mark.parametrize("v", ["0.7", "5.1", "-2.2"])
def test_functions_and_quotients_are_those_of_mpmath(k2, v):
    """Theta(v + i a) exp(i L v), L = (pi/2K) dlog theta_{1 or 2}(i w)/dw, DLMF 20.2."""
    m, x, part = F(k2), F(v), F(3, 10)
    with ctx.workprec(200), mpmath.workdps(80):
        functions = Jacobi(ball(m), ball(1 - m))
        here, begin = functions.at(ball(x)), functions.at(arb(0))
        parameter, u = (mpf(y.numerator) / y.denominator for y in (m, x))
        K, K_of_complement = mpmath.ellipk(parameter), mpmath.ellipk(1 - parameter)
        sn, cn, dn = here.functions
        for name, y in (("sn", here.side * sn), ("cn", here.side * cn), ("dn", dn)):
            right = mpmath.ellipfun(name, u, m=parameter)
            assert abs(core.number(y, 45) - right) < mpf("1e-40")
        q, a = mpmath.exp(-mpmath.pi * K_of_complement / K), K_of_complement * 3 / 10
        shift = ball(part) * Jacobi(ball(1 - m), ball(m)).K
        for half, kind, odd in ((False, 4, 1), (True, 3, 2)):
            w = mpmath.pi * a / 2 / K
            slope = 1j * mpmath.jtheta(odd, 1j * w, q, 1) / mpmath.jtheta(odd, 1j * w, q)
            rate = mpmath.pi / 2 / K * slope.real
            quotient = Shift(functions, shift, half)
            assert abs(core.number(quotient.rate, 45) - rate) < mpf("1e-38")
            here_value, begin_value = (
                mpmath.jtheta(kind, mpmath.pi * (y + 1j * a) / (2 * K), q)
                / mpmath.jtheta(4, mpmath.pi * y / (2 * K), q)
                for y in (u, mpf(0))
            )
            ratio = quotient.at(here) / quotient.at(begin)
            mine = mpmath.mpc(core.number(ratio.real, 45), core.number(ratio.imag, 45))
            assert abs(mine - here_value / begin_value) < mpf("1e-38") * abs(
                here_value / begin_value
            )
