"""Arrays of pairs of doubles: right to 2**-100."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from flint import arb

from polhode.numbers import double_double
from polhode.numbers.double_double import Pairs, of_balls, of_cells
from polhode.numbers.exact import sqrt
from polhode.numbers.flint_context import ctx

HIGH = mpmath.MPContext()
HIGH.prec = 400


def wide(x: Pairs) -> list[mpmath.mpf]:
    both = zip(np.ravel(x.hi).tolist(), np.ravel(x.lo).tolist(), strict=True)
    return [HIGH.mpf(a) + HIGH.mpf(b) for a, b in both]


def error(pairs: Pairs, true: list[mpmath.mpf]) -> float:
    """The largest relative error, in 2**-106."""
    each = zip(wide(pairs), true, strict=True)
    return max(float(abs(a - b) / abs(b) * HIGH.ldexp(1, 106)) for a, b in each)


def some(low: float, high: float, seed: int) -> Pairs:
    random = np.random.default_rng(seed)
    return Pairs(random.uniform(low, high, 300)) + Pairs(random.uniform(-1e-17, 1e-17, 300))


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("+", 0.3, 3), ("-", 0.3, 3), ("*", 0.3, 8), ("/", 0.3, 8), ("sqrt", 0.3, 4)],
)
def test_arithmetic_is_right_to_the_last_bits(name, least, most):
    x, y = some(1, 50, 1), some(60, 90, 2)
    pairs = {"+": x + y, "-": x - y, "*": x * y, "/": x / y, "sqrt": double_double.sqrt(x)}[name]
    a, b = wide(x), wide(y)
    operation = {
        "+": lambda p, q: p + q,
        "-": lambda p, q: p - q,
        "*": lambda p, q: p * q,
        "/": lambda p, q: p / q,
        "sqrt": lambda p, _: HIGH.sqrt(p),
    }[name]
    assert least < error(pairs, [operation(p, q) for p, q in zip(a, b, strict=True)]) < most


def test_numbers_become_pairs_and_lose_nothing_that_a_pair_holds():
    third = double_double.pairs(Fraction(1, 3))
    assert 0 < abs(Fraction(third.hi) + Fraction(third.lo) - Fraction(1, 3)) < Fraction(1, 2**106)
    root = double_double.pairs(sqrt(Fraction(2)))
    assert abs(Fraction(root.hi) + Fraction(root.lo)) ** 2 - 2 < Fraction(1, 2**104)
    values = [Fraction(k, 7**20) for k in range(-3, 4)]
    sums = double_double.of_fractions(values)
    for hi, lo, x in zip(sums.hi, sums.lo, values, strict=True):
        assert abs(Fraction(hi) + Fraction(lo) - x) <= abs(x) / 2**105
    with pytest.raises(TypeError, match="no number"):
        double_double.pairs("1")


def test_pairs_of_balls_and_cells_are_within_their_digits():
    with ctx.workprec(200):
        ((third, _),) = double_double.binary_numbers(of_balls([[arb(1) / 3, arb(2).sqrt()]]))
    assert abs(Fraction(*third.as_integer_ratio()) - Fraction(1, 3)) < Fraction(1, 10**31)
    cells = of_cells([Fraction(1, 3), None, 0.1, mpmath.mpf(2)])
    assert np.isnan(cells.hi[1])
    assert abs(Fraction(cells.hi[0]) + Fraction(cells.lo[0]) - Fraction(1, 3)) < Fraction(1, 10**31)
    assert (cells.hi[2], cells.lo[2], cells.hi[3]) == (0.1, 0, 2)
    with pytest.raises(ValueError, match="not a finite number"):
        of_cells([0.5, float("inf")])
    assert np.isnan(of_cells([None]).hi).all()
