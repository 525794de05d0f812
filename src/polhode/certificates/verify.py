"""Check a certificate of polhode: python-flint and the standard library, nothing else.

    python verify.py CERT.json

A certificate states balls that contain the state of a heavy rigid body at certain times, or that
the body has a periodic orbit, or that such an orbit is stable for all time, or that its motion is
chaotic (each theorem is written before its part of the code).  This file imports nothing of the
program that wrote the certificate, and takes from it only the body and the statement to be proved:
grids, centres, charts, sets and numbers of bits are guesses, and need not be right.

The equations, in body axes, O fixed, omega = w, upward vertical gamma, k = weight * centre:

    I w' = I w x w + gamma x k,    gamma' = gamma x w,        x = (w, gamma),  x' = f(x).

Where the attitude is stated, a unit quaternion Q that takes body axes to space, x has it too, and
f has Q' = Q (0, w)/2; x has n components, 6 or 10, and
f is quadratic: f(x + z) = f(x) + f'(x) z + B(z, z).  On a step of length h, tau in [0, 1], let p
be any polynomials, A = h f'(p), d = p' - h f(p).  The motion is p + z, where
z' = A z + h B(z, z) - d.  Norms are maxima, of matrices row sums; |B(z, z)| <= beta |z|^2.  With

    alpha >= int |A|,  delta >= int |d|,  eps >= |z(0)|,  e^alpha (eps + delta + |h| beta r^2) < r

|z| < r on the whole step, by Gronwall's lemma and continuity, and for any matrix polynomials V

    z(tau) in V(tau) z(0) + [-s, s]^n,   s = e^alpha (delta + |h| beta r^2) + rho eps,
    rho = e^alpha (|1 - V(0)| + int |A V - V'|),

by variation of constants.  The derivative D of the flow along such a motion obeys
D' = (A + E) D with |E| <= nu = 2 |h| beta r, for twice |B(z, v)| is at most 2 beta |z| |v|; so,
by Gronwall's lemma again, |D - V| <= rho + e^alpha (e^nu - 1).

Integrals of a polynomial's norm are bounded by the sums of the norms of its coefficients k over
k + 1, so the bounds hold for every tau.  The set of all z, and each column of the product of the
D's, is kept as m + sum_k W_k xi_k S_k, |xi_k| <= 1, with exact numbers: V carries m and the
directions S_k on, and a change of centre moves the m of z.
"""

from __future__ import annotations

import json
import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from functools import cache
from itertools import accumulate, chain, combinations, pairwise, zip_longest
from operator import mul
from typing import Generic, NamedTuple, TypeAlias, TypeVar

try:
    from flint import acb, arb, arb_mat, arb_poly, ctx, fmpq, fmpz
except ImportError:
    if __name__ != "__main__":
        raise
    print("python-flint is needed: pip install python-flint", file=sys.stderr)
    sys.exit(2)

FORMAT = "polhode certificate 1"
LARGEST = 64_000_000  # bytes of a file
LEAST_BITS, MOST_BITS, MOST_STEPS, MOST_DIGITS = 32, 4_000, 1_000_000, 20_000
SHORT = 600  # digits that Python itself reads and prints, however low its limit is set
FARTHEST = 20_000  # bits of a time or a state, before or after the point
MOST_WORK, EACH, HARD = 20_000_000_000, 100, 1000  # about an hour; see Run
NAMES = ("p", "q", "r", "gamma1", "gamma2", "gamma3")
UNKNOWN = (*NAMES, "the period", "lam1", "lam2", "lam3")
TURN = ("q0", "q1", "q2", "q3")
#: Of each component of Q (0, w) its products: sign, component of Q, component of w.
TURNING = (
    ((-1, 1, 0), (-1, 2, 1), (-1, 3, 2)),
    ((1, 0, 0), (1, 2, 2), (-1, 3, 1)),
    ((1, 0, 1), (1, 3, 0), (-1, 1, 2)),
    ((1, 0, 2), (1, 1, 1), (-1, 2, 0)),
)
GROUP = 24  # steps
SPARE = 16  # bits of a guess's numbers beyond those asked for
MOST_TERMS = 120  # of V
COARSE = 64  # bits of matrices and bounds
STATES, DERIVATIVES, SETS = 52, 64, 20  # bits to which V is made, by what is carried

Interval = tuple[Fraction, Fraction]  # middle and radius
Claim = tuple[Fraction, list[Interval]]  # a time and six balls, with the attitude ten
Table: TypeAlias = list[list[arb]]
Tell: TypeAlias = Callable[[float, int], None]  # the part of the steps that is done, and how many
Y = TypeVar("Y", arb, arb_poly, acb)  # coefficients of jets
Z = TypeVar("Z", "arb", "arb_poly", "Jet[arb]", "Jet[arb_poly]")


class NotProved(Exception):
    """The first inequality that does not hold, in words."""


class Damaged(Exception):
    """What of a file is no certificate."""


# -- reading ------------------------------------------------------------------------------------


def read(path: str) -> bytes:
    """The bytes of a file, of the standard input for ``-``; raises Damaged."""
    try:
        if path == "-":
            return sys.stdin.buffer.read(LARGEST + 1)
        with open(path, "rb") as file:
            return file.read(LARGEST + 1)
    except (OSError, ValueError) as fault:
        raise Damaged(str(fault)) from None


def parse(data: bytes) -> object:
    """A certificate's bytes as JSON's objects; raises Damaged."""
    if len(data) > LARGEST:
        raise Damaged(f"larger than {LARGEST} bytes")
    try:
        return json.loads(data, object_pairs_hook=_once, parse_int=_integer)
    except (ValueError, RecursionError) as fault:
        raise Damaged(f"no JSON ({fault})") from None


def _integer(text: str) -> float:
    """Of any size up to MOST_DIGITS, whatever Python's own limit is.

    A longer one becomes a float, which is refused where it stands, as all floats are.
    """
    return int(fmpz(text)) if len(text) <= MOST_DIGITS else math.inf


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    table = dict(pairs)
    if len(table) != len(pairs):
        raise Damaged("a key stands twice")
    return table


def _keys(table: object, names: Sequence[str], where: str) -> list[object]:
    if not isinstance(table, dict) or set(table) != set(names):
        raise Damaged(f"{where}: expected the keys {', '.join(names)}, nothing else")
    return [table[name] for name in names]


def _whole(value: object, low: int, high: int, where: str) -> int:
    if type(value) is not int or not low <= value <= high:
        raise Damaged(f"{where}: expected a whole number from {low} to {high}")
    return value


def _long(value: object, where: str) -> int:
    if type(value) is not int or value.bit_length() > FARTHEST:
        raise Damaged(f"{where}: expected a whole number of at most {FARTHEST} bits")
    return value


def _wholes(value: object, length: int | None, where: str) -> list[int]:
    return [_long(x, f"{where}[{n}]") for n, x in enumerate(_list(value, length, where))]


def _rows(value: object, length: int, width: int, where: str) -> list[list[int]]:
    rows = _list(value, length, where)
    return [_wholes(row, width, f"{where}[{n}]") for n, row in enumerate(rows)]


def _list(value: object, length: int | None, where: str) -> list[object]:
    if not isinstance(value, list) or (length is not None and len(value) != length):
        raise Damaged(f"{where}: expected a list" + (f" of {length}" if length else ""))
    return value


def _rational(value: object, where: str) -> Fraction:
    """An integer, or a text such as -1.25, 3e-40 or 2/7."""
    if type(value) is int:
        return Fraction(value)
    if isinstance(value, str) and len(value) <= MOST_DIGITS and value.isascii():
        _, _, power = value.lower().partition("e")
        if len(power.lstrip("+-")) <= 4 and "_" not in value:
            try:
                return _fraction(value)
            except (ValueError, ZeroDivisionError):
                pass
    expected = "a whole number, or a text with a decimal or a fraction"
    raise Damaged(f"{where}: expected {expected}, of at most {MOST_DIGITS} digits")


def _fraction(text: str) -> Fraction:
    if len(text) < SHORT:
        return Fraction(text)
    match = re.fullmatch(r"([-+]?\d+)(?:/(\d+)|(?:\.(\d*))?(?:e([-+]?\d+))?)", text.lower())
    if not match:
        raise ValueError
    whole, below, places, power = (x or "" for x in match.groups())
    if below:
        return Fraction(int(fmpz(whole)), int(fmpz(below)))
    ten = int(power or 0) - len(places)
    return int(fmpz((whole + places).lstrip("+"))) * Fraction(10) ** ten


def _interval(value: object, where: str) -> Interval:
    """Middle and radius: of one number, or of two in a list."""
    if isinstance(value, list):
        middle, radius = (
            _rational(x, f"{where}[{n}]") for n, x in enumerate(_list(value, 2, where))
        )
        if radius < 0:
            raise Damaged(f"{where}[1]: expected a radius that is not negative")
        return middle, radius
    return _rational(value, where), Fraction(0)


def ball(interval: Interval) -> arb:
    """Middle and radius, rationals, as a ball at the present precision."""
    middle, radius = (arb(fmpq(x.numerator, x.denominator)) for x in interval)
    return middle + arb(0, upper(radius)) if interval[1] else middle


def dyadic(number: int, power: int) -> arb:
    """number 2^power, exact at any precision."""
    value = arb((number, power))
    certainly(value.is_exact(), "a number is longer than its bits")
    return value


# -- balls --------------------------------------------------------------------------------------


def upper(x: arb) -> arb:
    """A number that no value of a ball exceeds in modulus, exact."""
    return x.abs_upper()


def certainly(true: object, line: str) -> None:
    """Refuse unless a comparison of balls is certain; one with nan is not."""
    if true is not True:
        raise NotProved(line)


def inverse(matrix: arb_mat, line: str) -> arb_mat:
    """The inverse of a matrix; refuse one that may have none."""
    try:
        return matrix.inv()
    except ZeroDivisionError:
        raise NotProved(line) from None


def largest(numbers: Iterable[arb]) -> arb:
    """An upper bound of the moduli of several numbers."""
    bound = arb(0)
    for x in numbers:
        bound = bound.max(upper(x))
    return bound


def summed(numbers: Iterable[arb]) -> arb:
    """Their sum."""
    return sum(numbers, arb(0))


def row_sum(rows: Sequence[Sequence[arb]]) -> arb:
    """An upper bound of the norm of a matrix: its largest row sum."""
    return largest([summed(map(upper, row)) for row in rows])


def integral(norms: Iterable[arb]) -> arb:
    """An upper bound of the integral over a step, from bounds of each coefficient."""
    return upper(summed(x / (k + 1) for k, x in enumerate(norms)))


# -- the body -----------------------------------------------------------------------------------


class Body:
    """f as tables of coefficients, balls; what is exactly zero stands nowhere.

    ``turns``: whether the attitude is one of its variables.
    """

    def __init__(
        self, inertia: Sequence[Sequence[arb]], torque: Sequence[arb], turns: bool = False
    ) -> None:
        #: (row, a, b): the coefficient of x_a x_b, a <= b; (row, j): of x_j.
        self.quadratic: dict[tuple[int, ...], arb] = {}
        self.linear: dict[tuple[int, ...], arb] = {}
        for i, n, weight in _inverse(inertia):
            a, b = (n + 1) % 3, (n + 2) % 3
            for j in range(3):  # (I w x w)_n = (I w)_a w_b - (I w)_b w_a
                self._add(self.quadratic, (i, min(j, b), max(j, b)), weight * inertia[a][j])
                self._add(self.quadratic, (i, min(j, a), max(j, a)), -weight * inertia[b][j])
            self._add(self.linear, (i, 3 + a), weight * torque[b])  # (gamma x k)_n
            self._add(self.linear, (i, 3 + b), -weight * torque[a])
        for i in range(3):  # gamma x w
            a, b = (i + 1) % 3, (i + 2) % 3
            self._add(self.quadratic, (3 + i, b, 3 + a), arb(1))
            self._add(self.quadratic, (3 + i, a, 3 + b), arb(-1))
        for i, terms in enumerate(TURNING if turns else ()):
            for sign, a, b in terms:
                self._add(self.quadratic, (6 + i, b, 6 + a), arb(sign) / 2)
        self.beta = largest(
            summed(upper(x) for (row, *_), x in self.quadratic.items() if row == i)
            for i in range(10)
        )

    @staticmethod
    def _add(table: dict[tuple[int, ...], arb], key: tuple[int, ...], x: arb) -> None:
        entry = table.pop(key, arb(0)) + x
        if not (entry.is_exact() and entry == 0):
            table[key] = entry

    def field(self, x: Sequence[Z], product: Callable[[int, int], Z]) -> list[Z]:
        """The rates: ``x`` their values, ``product(i, j)`` that of two of them."""
        rates = []
        for i in range(len(x)):
            terms = [product(a, b) * k for (row, a, b), k in self.quadratic.items() if row == i]
            terms += [x[j] * k for (row, j), k in self.linear.items() if row == i]
            rates.append(sum(terms, x[i] * arb(0)))
        return rates

    def derivative(self, x: Sequence[arb_poly]) -> dict[tuple[int, int], arb_poly]:
        """The entries of f'(x) that are not zero, by row and column; x polynomials."""
        entries: dict[tuple[int, int], arb_poly] = {}

        def add(i: int, j: int, term: arb_poly) -> None:
            entries[i, j] = entries[i, j] + term if (i, j) in entries else term

        for (i, a, b), k in self.quadratic.items():
            add(i, a, x[b] * k)
            add(i, b, x[a] * k)
        for (i, j), k in self.linear.items():
            add(i, j, arb_poly([k]))
        return entries


def _inverse(inertia: Sequence[Sequence[arb]]) -> list[tuple[int, int, arb]]:
    """The entries of the inverse matrix, by row and column; a diagonal one's is as sharp as it."""
    if all(inertia[i][j] == 0 for i in range(3) for j in range(3) if i != j):
        return [(i, i, 1 / inertia[i][i]) for i in range(3)]
    inverse = arb_mat(inertia).inv()
    return [(i, n, inverse[i, n]) for i in range(3) for n in range(3)]


# -- guesses, which nothing rests on ------------------------------------------------------------


class Algebra(NamedTuple):
    """Numbers of several parts: a part of a product is a sum over pairs of the factors' parts.

    ``factors``: of each part these pairs, none of a part behind it; ``shifts``: by how many bits it
    counts less than the first.
    """

    factors: Sequence[Sequence[tuple[int, int]]]
    shifts: Sequence[int]


NUMBERS = Algebra([[(0, 0)]], [0])


def taylor(body: Body, centre: Sequence[arb], h: arb, bits: int) -> list[list[arb]]:
    """Exact coefficients, but for the first, of polynomials near the motion from a centre."""
    return [row for (row,) in taylor_over(NUMBERS, body, [[x] for x in centre], h, bits)]


def taylor_over(
    algebra: Algebra, body: Body, centre: Sequence[Sequence[arb]], h: arb, bits: int
) -> list[list[list[arb]]]:
    """The same of each part of the numbers of an algebra.

    They are whole multiples of 2^-fine, as is all below.
    """
    fine, small = bits + SPARE, 0
    quadratic = [(place, _fixed(k, fine)) for place, k in body.quadratic.items()]
    linear = [(place, _fixed(k, fine)) for place, k in body.linear.items()]
    rows, length = [[[_fixed(x, fine)] for x in parts] for parts in centre], _fixed(h, fine)
    pairs = {(a, b) for (_, a, b), _ in quadratic}
    operands = [
        [((a, b), [(rows[a][i], rows[b][j]) for i, j in factors]) for a, b in pairs]
        for factors in algebra.factors
    ]
    for k in range(bits + 20):
        size = 0
        for m in reversed(range(len(operands))):  # the parts before m are as long as it
            products = {}
            for pair, factors in operands[m]:
                total = 0
                for left, right in factors:
                    total += sum(map(mul, left, reversed(right)))
                products[pair] = total >> fine
            rates = [0] * len(rows)
            for (i, a, b), x in quadratic:
                rates[i] += x * products[a, b]
            for (i, j), x in linear:
                rates[i] += x * rows[j][m][k]
            news = [(rate * length >> 2 * fine) // (k + 1) for rate in rates]
            for row, new in zip(rows, news, strict=True):
                row[m].append(new)
            size = max(size, max(map(abs, news)) >> algebra.shifts[m])
        small = small + 1 if size >> SPARE == 0 else 0
        if small == 2 or size >> 4 * fine:
            break
    return [[[arb((n, -fine)) for n in row[1:]] for row in parts] for parts in rows]


def _fixed(x: arb, fine: int) -> int:
    """A whole multiple of 2^-fine near a ball."""
    if not x.is_finite():
        return 0
    whole, power = (int(n) for n in x.mid().man_exp())
    return whole << power + fine if power + fine >= 0 else whole >> -power - fine


def next_of_v(total: arb_mat, k: int) -> arb_mat:
    """An exact matrix near the coefficient k + 1 of V, ``total`` being that of V' before it."""
    return (total / arb(k + 1)).mid()


# -- one step, and the set ----------------------------------------------------------------------


class Step:
    """Polynomials p and V about a centre, and those bounds of the theorem that need no set."""

    def __init__(self, body: Body, centre: Sequence[arb], h: arb, bits: int, fine: int) -> None:
        ctx.prec = bits
        self.bits = bits
        rows = zip(centre, taylor(body, centre, h, bits), strict=True)
        self.p = [arb_poly([x, *row]) for x, row in rows]  # p(0) is the centre
        rates = body.field(self.p, lambda i, j: self.p[i] * self.p[j])
        defect = [
            (row.derivative() - rate * h).coeffs() for row, rate in zip(self.p, rates, strict=True)
        ]
        ctx.prec = COARSE
        self.delta = integral([largest(some) for some in zip_longest(*defect, fillvalue=arb(0))])
        a = matrices_of(body.derivative(self.p), h, len(centre))
        norms = [row_sum(x.table()) for x in a]
        self.growth = upper(integral(norms).exp())
        self.beta = upper(h) * body.beta
        self.v, residual = transition(a, norms, fine)
        self.rho = self.growth * residual

    def reach(self, eps: arb) -> arb:
        """r for all |z(0)| <= eps; raises NotProved where the theorem's condition fails."""
        r = upper(2 * self.growth * (eps + self.delta)) + arb(2) ** -100_000
        claimed = self.growth * (eps + self.delta + self.beta * r * r)
        certainly(claimed < r, "the condition of the step")
        return r

    def noise(self, eps: arb, r: arb) -> arb:
        """s for all |z(0)| <= eps, r their reach."""
        return upper(self.growth * (self.delta + self.beta * r * r) + self.rho * eps)

    def noise_of_derivative(self, r: arb) -> arb:
        """A bound of |D - V|, D the derivative of the flow along any motion within r."""
        return upper(self.rho + self.growth * (2 * self.beta * r).expm1())

    def steepness(self, body: Body, r: arb) -> arb:
        """A bound of |f'|, Euclidean, within r of p."""
        box = [
            row[0] + arb(0, upper(summed(upper(x) for x in row.coeffs()[1:]) + r)) for row in self.p
        ]
        return steepness(slope(body, box))

    def at(self, tau: arb) -> tuple[list[arb], arb_mat]:
        """p and V at a moment of the step, a number from 0 to 1."""
        ctx.prec = self.bits
        middle = [row(tau) for row in self.p]
        ctx.prec = COARSE
        matrix = self.v[-1]
        for coefficient in self.v[-2::-1]:
            matrix = matrix * tau + coefficient
        return middle, matrix


def matrices_of(
    entries: Mapping[tuple[int, int], arb_poly], h: arb, size: int = 6
) -> list[arb_mat]:
    """The coefficients of h times a matrix of polynomials, of at least one."""
    rows = {place: (x * h).coeffs() for place, x in entries.items()}
    matrices = [arb_mat(size, size) for _ in range(max(1, *map(len, rows.values())))]
    for place, row in rows.items():
        for matrix, x in zip(matrices, row, strict=False):
            matrix[place] = x
    return matrices


def transition(a: Sequence[arb_mat], norms: Sequence[arb], fine: int) -> tuple[list[arb_mat], arb]:
    """Exact coefficients near those of V' = A V, V(0) = 1, to 2^-fine; a bound of int |A V - V'|.

    V(0) is the unit matrix exactly.  Coefficients of the residual below V's degree are computed,
    the others bounded by the norms of A's and V's.
    """
    v, sizes, small = [arb_mat(_unit(a[0].nrows()))], [arb(1)], 0
    least, residual = arb(2) ** -fine, arb(0)
    while small < 2 and len(v) < MOST_TERMS:
        k = len(v) - 1
        total = sum((a[j] * v[k - j] for j in range(1, min(len(a), k + 1))), a[0] * v[k])
        v.append(next_of_v(total, k))
        residual += rough(total - v[-1] * arb(k + 1)) / (k + 1)
        sizes.append(rough(v[-1]))
        small = small + 1 if sizes[-1] < least else 0
    last = len(v) - 1
    after = [*accumulate(reversed(sizes))][::-1]  # |V_k| + |V_k+1| + ...
    rest = summed(norm * after[max(0, last - j)] for j, norm in enumerate(norms))
    return v, upper(residual + rest / (last + 1))


def rough(matrix: arb_mat) -> arb:
    """An upper bound of the norm, at most as many times as large as it has rows."""
    return upper((matrix.nrows() * upper((matrix * matrix.transpose()).trace())).sqrt())


class Set:
    """Columns that V carries on, of which each is known but for a box in common directions.

    Column j is one of m_j + sum_k W_kj xi_k S_k, |xi_k| <= 1.  The first columns are z, of one or
    several sets of starts; those after them are the columns of D, the derivative of the flow.  A
    step adds n directions, its noise; after a group of steps those of the group become n, the
    smallest box around them.
    """

    def __init__(self, m: Table, box: Table, states: int) -> None:
        self.m, self.states = m, states
        self.s, self.w = _unit(len(m)), box  # S by rows, W by directions
        self.old = len(m)  # directions that stand before the group's

    def sizes(self) -> list[arb]:
        """Upper bounds of the columns."""
        around = _bounds(self.s, self.w)
        rows = [
            [upper(x) + y for x, y in zip(*pair, strict=True)]
            for pair in zip(self.m, around, strict=True)
        ]
        return [largest(column) for column in zip(*rows, strict=True)]

    def carried(self, v: arb_mat, noise: Sequence[arb]) -> tuple[Table, Table, Table]:
        """Where a step takes it: m as balls, S as exact numbers, and bounds of what is left out."""
        moved = (v * arb_mat(self.m)).table()
        rows = (v * arb_mat(self.s)).table()
        rounded = _bounds([[x.rad() for x in row] for row in rows], self.w)
        left = [[upper(x + y) for x, y in zip(row, noise, strict=True)] for row in rounded]
        return moved, [[x.mid() for x in row] for row in rows], left

    def within(self, step: Step, noise: Sequence[arb], tau: Fraction) -> Table:
        """The columns at a moment of a step that begins here, as balls: motions, not z."""
        ctx.prec = step.bits
        middle, v = step.at(ball((tau, Fraction(0))))
        moved, rows, left = self.carried(v, noise)
        around = _bounds(rows, self.w)
        ctx.prec = step.bits
        table = []
        for i in range(len(middle)):
            row = zip(moved[i], around[i], left[i], strict=True)
            balls = [x + arb(0, upper(y + z)) for x, y, z in row]
            table.append([x + middle[i] for x in balls[: self.states]] + balls[self.states :])
        return table

    def next(self, step: Step, noise: Sequence[arb], centre: Sequence[arb]) -> Set:
        """The set about the next centre."""
        unit, count = _unit(len(centre)), len(centre)
        middle, v = step.at(arb(1))
        moved, rows, left = self.carried(v, noise)
        ctx.prec = step.bits
        for i, row in enumerate(moved):
            jump = middle[i] - centre[i]
            row[: self.states] = [x + jump for x in row[: self.states]]
        ctx.prec = COARSE
        new = [
            [upper(x.rad() + y) for x, y in zip(*pair, strict=True)]
            for pair in zip(moved, left, strict=True)
        ]
        successor = Set([[x.mid() for x in row] for row in moved], new, self.states)
        successor.old = self.old
        if len(rows[0]) + count - self.old > count * GROUP:
            box = _bounds([row[self.old :] for row in rows], self.w[self.old :])
            rows = [row[: self.old] + more for row, more in zip(rows, unit, strict=True)]
            successor.w = self.w[: self.old] + box + new
            successor.old = self.old + count
        else:
            successor.w = self.w + new
        successor.s = [row + more for row, more in zip(rows, unit, strict=True)]
        return successor


def _unit(size: int = 6) -> Table:
    return [[arb(int(i == j)) for j in range(size)] for i in range(size)]


def _bounds(rows: Table, weights: Table) -> Table:
    """Upper bounds of the entries of |rows| weights."""
    sizes = arb_mat([[upper(x) for x in row] for row in rows])
    return [[upper(x) for x in row] for row in (sizes * arb_mat(weights)).table()]


# -- along a grid -------------------------------------------------------------------------------


class Guesses(NamedTuple):
    """The grid, in units of 2^-time_bits, and a centre of each step, in units of 2^-state_bits."""

    time_bits: int
    grid: list[int]
    state_bits: int
    centres: list[list[int]]
    bits: int


def read_guesses(values: Sequence[object], where: str = "", more: int = 0) -> Guesses:
    """The guesses of a certificate, in the order of Guesses; raises Damaged.

    ``where``: the place of what holds them; ``more``: states besides those of the grid.
    """
    time_bits = _whole(values[0], -FARTHEST, FARTHEST, f"{where}time_bits")
    grid = _grid(values[1], f"{where}grid")
    state_bits = _whole(values[2], -FARTHEST, FARTHEST, f"{where}state_bits")
    bits = _whole(values[4], LEAST_BITS, MOST_BITS, "bits")
    check_work(len(grid) + more, bits)
    centres = _rows(values[3], len(grid) - 1, 6, f"{where}centres")
    return Guesses(time_bits, grid, state_bits, centres, bits)


def check_work(steps: int, bits: int) -> None:
    """Refuse what would take hours; raises Damaged."""
    if steps * (bits + EACH) ** 2 * (1 + bits / HARD) > MOST_WORK:
        raise Damaged(f"{steps} steps and states at {bits} bits are too many")


class Run:
    """A body, a grid and centres, in the unit of time 2^-shift, in which rates are about 1.

    ``turn``: the attitude at the start, where it is one of the variables.
    """

    def __init__(
        self, guesses: Guesses, inertia: Table, torque: Sequence[arb], turn: Sequence[arb] = ()
    ) -> None:
        """Raises NotProved."""
        self.time_bits, self.grid, state_bits, rows, self.bits = guesses
        begin = [dyadic(x, -state_bits) for x in rows[0]]
        try:
            self.shift = scaling(inertia, torque, begin)
            self.inertia, by = inertia, arb(2) ** (-2 * self.shift)
            self.torque = [x * by for x in torque]
            self.body = Body(inertia, self.torque, bool(turn))
        except (ZeroDivisionError, OverflowError, ValueError):
            raise NotProved("the body's moments of inertia have no inverse") from None
        self.rates = [*[arb(2) ** -self.shift] * 3, *[arb(1)] * (3 + len(turn))]
        powers = [-state_bits - self.shift] * 3 + [-state_bits] * 3
        self.centres = [[dyadic(x, e) for x, e in zip(row, powers, strict=True)] for row in rows]
        self.centres[0] += [x.mid() for x in turn]

    @property
    def unit(self) -> Fraction:
        """The grid's unit, in the scene's units."""
        return Fraction(2) ** -self.time_bits

    def stages(self, columns: Set, fine: int, tell: Tell | None) -> Iterator[Stage]:
        """Each step, with the set at its start; raises NotProved."""
        count, centre = len(self.centres), self.centres[0]
        for n, (first, last) in enumerate(pairwise(self.grid)):
            if tell is not None:
                tell(n / count, n)
            try:
                ctx.prec = self.bits
                h = dyadic(last - first, self.shift - self.time_bits)
                step = Step(self.body, centre, h, self.bits, fine)
                sizes = columns.sizes()
                reach = [step.reach(eps) for eps in sizes[: columns.states]]
                noise = [step.noise(eps, r) for eps, r in zip(sizes, reach, strict=False)]
                of_d = step.noise_of_derivative(largest(reach))
                noise += [upper(of_d * size) for size in sizes[columns.states :]]
                yield Stage(first, last, step, largest(reach), noise, columns)
                if n + 1 < count:
                    ctx.prec = self.bits  # of an attitude the centre is where the last step ends
                    centre = [*self.centres[n + 1], *(x(arb(1)).mid() for x in step.p[6:])]
                    columns = columns.next(step, noise, centre)
            except (ZeroDivisionError, OverflowError):
                raise NotProved(f"step {n + 1}: a number is too large") from None
            except NotProved as fault:
                raise NotProved(f"step {n + 1} of {count}: {fault}") from None


class Stage(NamedTuple):
    """A step from one time of a grid to the next; ``reach``: |z| stays below it."""

    first: int
    last: int
    step: Step
    reach: arb
    noise: list[arb]
    before: Set

    def at(self, time: Fraction) -> Table:
        """The columns at a time of the step, in the grid's unit; raises NotProved."""
        tau = (time - self.first) / (self.last - self.first)
        if not 0 <= tau <= 1:
            raise NotProved("a time is not in the step that should contain it")
        return self.before.within(self.step, self.noise, tau)


# -- a claim: states ----------------------------------------------------------------------------


def _contents(certificate: object, more: Sequence[str] = ()) -> dict[str, object]:
    names = ("format", "kind", "scene", *Guesses._fields, *more, "statement")
    return dict(zip(names, _keys(certificate, names, "the certificate"), strict=True))


def state(certificate: object, tell: Tell | None = None) -> list[str]:
    """What a certificate of states proves; raises NotProved, Damaged."""
    contents = _contents(certificate)
    claims = _claims(contents["statement"])
    turns = sum(len(balls) > 6 for _, balls in claims)
    scene = read_scene(contents["scene"])
    if turns and len(scene[2]) == 6:
        raise Damaged("scene: expected attitude, which the statement is about")
    guesses = read_guesses([contents[name] for name in Guesses._fields], more=len(claims))
    ctx.prec = guesses.bits + 2 * COARSE
    _check_start(claims, scene[2])
    inertia, torque, start = balls_of(scene)
    if turns:
        _check_vertical(start[3:6], start[6:])
    start = start if turns else start[:6]
    run = Run(guesses, inertia, torque, start[6:])
    sense, unit = (1 if run.grid[-1] > 0 else -1), run.unit
    for t, _ in claims:
        if not 0 <= sense * t <= sense * run.grid[-1] * unit:
            raise NotProved(f"t = {written(t)} lies outside the grid")
    rows = zip(start, run.rates, run.centres[0], strict=True)
    offset = [x * rate - y for x, rate, y in rows]
    begin = Set([[x.mid()] for x in offset], [[upper(x.rad())] for x in offset], 1)
    left = sorted((claim for claim in claims if claim[0]), key=lambda claim: -abs(claim[0]))
    for stage in run.stages(begin, STATES, tell):
        while left and sense * left[-1][0] <= sense * stage.last * unit:
            claim = left.pop()
            there = zip(stage.at(claim[0] / unit), run.rates, strict=True)
            _check(claim, [row[0] / rate for row, rate in there])
    last = written(max((t for t, _ in claims), key=abs))
    widest = max(radius for _, balls in claims for _, radius in balls)
    too = f" and at {turns} its attitude" if turns else ""
    return [
        f"proved: at {len(claims)} times up to t = {last} the motion of this scene{too} "
        f"lies in the balls that the certificate states, of radius {rounded_up(widest)} at most"
    ]


def _check_vertical(gamma: Sequence[arb], q: Sequence[arb]) -> None:
    """Refuse an attitude that has another gamma."""
    vertical = [
        2 * (q[1] * q[3] - q[0] * q[2]),
        2 * (q[2] * q[3] + q[0] * q[1]),
        q[0] ** 2 - q[1] ** 2 - q[2] ** 2 + q[3] ** 2,
    ]
    for x, y in zip(vertical, gamma, strict=True):
        if not x.overlaps(y):
            raise NotProved("the attitude at t = 0 has another gamma than the scene")


def _grid(value: object, where: str) -> list[int]:
    grid = _wholes(value, None, where)
    if not 2 <= len(grid) <= MOST_STEPS or grid[0] != 0:
        raise Damaged(f"{where}: expected 0 and up to {MOST_STEPS} times after it")
    sense = 1 if grid[1] > 0 else -1
    if any(sense * (b - a) <= 0 for a, b in pairwise(grid)):
        raise Damaged(f"{where}: expected times in order away from 0")
    return grid


Scene = tuple[list[list[Interval]], list[list[Interval]], list[Interval]]


def read_scene(scene: object) -> Scene:
    """Inertia, centre and weight, and start of a scene, with its attitude where it has one."""
    has_turn = isinstance(scene, dict) and "attitude" in scene
    return read_body(scene, ("omega", "gamma", *["attitude"] * has_turn))


def read_body(scene: object, names: Sequence[str]) -> Scene:
    """Inertia, centre and weight of a body, and the vectors of those names in one list."""
    diagonal = isinstance(scene, dict) and "moments" in scene
    names = ("moments" if diagonal else "inertia", "centre", "weight", *names)
    form, centre, weight, *vectors = _keys(scene, names, "scene")
    none = (Fraction(0), Fraction(0))
    if diagonal:
        moments = _intervals(form, 3, "scene.moments")
        rows = [[moments[i] if i == j else none for j in range(3)] for i in range(3)]
    else:
        rows = [
            _intervals(row, 3, f"scene.inertia[{n}]")
            for n, row in enumerate(_list(form, 3, "scene.inertia"))
        ]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise Damaged("scene.inertia: expected a symmetric matrix")
    load = [_intervals(centre, 3, "scene.centre"), [_interval(weight, "scene.weight")]]
    start: list[Interval] = []
    for name, vector in zip(names[3:], vectors, strict=True):
        start += _intervals(vector, 4 if name == "attitude" else 3, f"scene.{name}")
    return rows, load, start


def _intervals(value: object, count: int, where: str) -> list[Interval]:
    return [_interval(x, f"{where}[{n}]") for n, x in enumerate(_list(value, count, where))]


def balls_of(scene: Scene) -> tuple[list[list[arb]], list[arb], list[arb]]:
    """Inertia, torque and start as balls at the present precision."""
    rows, (centre, (weight,)), start = scene
    inertia = [[ball(x) for x in row] for row in rows]
    return inertia, [ball(weight) * ball(x) for x in centre], [ball(x) for x in start]


def scaling(inertia: Sequence[Sequence[arb]], torque: Sequence[arb], start: Sequence[arb]) -> int:
    """The n of a unit of time 2^-n in which rates are about 1: any would do."""
    least = min(abs(float(inertia[i][i])) for i in range(3))
    swing = max(abs(float(x)) for x in torque) / least if least else 0.0
    rate = max(swing**0.5, *(abs(float(x)) for x in start[:3]))
    return math.frexp(rate)[1] if 0 < rate < float("inf") else 0


def _claims(statement: object) -> list[Claim]:
    """Those of the state, where it is stated with the attitude."""
    claims: list[Claim] = []
    for n, row in enumerate(_list(statement, None, "statement")):
        where = f"statement[{n}]"
        has_turn = isinstance(row, dict) and "attitude" in row
        time, balls, *more = _keys(row, ("t", "balls", *["attitude"] * has_turn), where)
        row_of_balls = _balls(balls, 6, f"{where}.balls")
        for turn in more:
            row_of_balls += _balls(turn, 4, f"{where}.attitude")
        claims.append((_rational(time, f"{where}.t"), row_of_balls))
    if not claims:
        raise Damaged("statement: expected at least one time")
    return claims


def _balls(value: object, count: int, where: str) -> list[Interval]:
    for n, pair in enumerate(_list(value, count, where)):
        _list(pair, 2, f"{where}[{n}]")
    return _intervals(value, count, where)


def _check_start(claims: Sequence[Claim], start: Sequence[Interval]) -> None:
    for t, balls in claims:
        if t != 0:
            continue
        for name, (x, r), (middle, radius) in zip((*NAMES, *TURN), start, balls, strict=False):
            if abs(x - middle) + r > radius:
                raise NotProved(f"{name} at t = 0 is not in its ball")


def _check(claim: Claim, there: Sequence[arb]) -> None:
    t, balls = claim
    for name, x, pair in zip((*NAMES, *TURN), there, balls, strict=False):
        _inside(x, pair, f"{name} at t = {written(t)}")


def written(t: Fraction) -> str:
    """A time in full where that is short, else what it is about."""
    text = str(t) if abs(t.numerator) < 10**20 and t.denominator < 10**20 else ""
    return text or f"about {decimal(abs(t), up=False, minus=t < 0)}"


def rounded_up(x: Fraction) -> str:
    """A bound with two digits, not below the number."""
    return decimal(x, up=True, minus=False) if x else "0"


def decimal(x: Fraction, up: bool, minus: bool) -> str:
    """Two digits and an exponent, of any size."""
    two = Context(2, ROUND_CEILING if up else ROUND_FLOOR)
    value = two.divide(Decimal(x.numerator), Decimal(x.denominator))
    digits, power = f"{value:.1e}".split("e")
    return f"{'-' * minus}{digits}e{int(power):+03d}"


# -- a claim: a periodic orbit ------------------------------------------------------------------

#: On the level c = (2 h, f, |gamma|^2) of H = (w.Iw + 2 k.gamma, Iw.gamma, gamma.gamma), with x*
#: the first centre, T* the grid's end, W and a guesses near DH(x*)^T and f(x*), phi the flow, let
#:
#:     F(x, T, lam) = (phi_T(x) - x - W lam,  a.(x - x*),  H(x) - c),     ten equations for ten
#:
#: numbers in Y: |x - x*| <= r, |T - T*| <= 4 r < T*, |lam| <= 4 r.  If for some matrix C every
#: component of K - y* = -C F(y*) + (1 - C DF(Y)) (Y - y*) is smaller than Y's radius, F has exactly
#: one zero in Y, and it lies in K (Krawczyk).  H is conserved, so a mean of the matrices
#: DH(x + s W lam) W takes lam to 0; where the matrix of balls DH(X + W Lam) W has a determinant
#: without 0, lam = 0: a periodic orbit of the level.  No equilibrium: there DF has a column of 0.
#: D, the flow's derivative, has there the eigenvalue 1 four times and the determinant 1; so
#: R = (6 - tr D)/4 tells the two others: real and positive for R < 0, of modulus 1 between 0 and 1,
#: real and negative for R > 1.  A motion of the level that passes within r/(1 + v |a|_1/m) of x*,
#: |f| <= v and a.f >= m > 0 in the box, meets the plane a.(x - x*) = 0 in it; if it has a period
#: within 4 r of T*, it is the zero.  The least period: a period is at least 2 pi/L, L >= |f'| on
#: the orbit, Euclidean (Yorke 1969, for a Lipschitz constant; but for u = x'/|x'|, x'' = f'(x) x'
#: makes |u'| <= L; x is closed, so the integral of u |x'| is 0 and u is in no open half sphere;
#: such a closed curve is at least 2 pi long (Fenchel 1929): L T >= 2 pi).  If T = j T_0, T/p is a
#: period for each prime p that divides j, and p <= T L/(2 pi).
STABILITY: dict[str, Callable[[arb], object]] = {
    "hyperbolic": lambda r: r < 0,
    "elliptic": lambda r: (r > 0) is True and (r < 1) is True,
    "inverse hyperbolic": lambda r: r > 1,
}
MOST_PARTS = 10_000  # primes by which a period is divided are smaller


class Orbit(NamedTuple):
    """What is stated of a periodic orbit; ``alone``: how far in omega, gamma and period."""

    kind: str
    start: list[Interval]
    period: Interval
    residue: Interval
    least: bool
    alone: list[Fraction]


def read_orbit(statement: object) -> Orbit:
    """The statement of a certificate of an orbit; raises Damaged."""
    kind, start, period, residue, least, alone = _keys(statement, Orbit._fields, "statement")
    if not isinstance(kind, str) or kind not in STABILITY:
        raise Damaged(f"statement.kind: expected {' or '.join(STABILITY)}")
    if type(least) is not bool:
        raise Damaged("statement.least: expected true or false")
    balls = _intervals(start, 6, "statement.start")
    near, rest = _interval(period, "statement.period"), _interval(residue, "statement.residue")
    where = "statement.alone"
    far = [_rational(x, f"{where}[{n}]") for n, x in enumerate(_list(alone, 3, where))]
    if min(far) < 0:
        raise Damaged(f"{where}: expected no negative numbers")
    return Orbit(kind, balls, near, rest, least, far)


def orbit(certificate: object, tell: Tell | None = None) -> list[str]:
    """What a certificate of a periodic orbit proves; raises NotProved, Damaged."""
    contents = _contents(certificate, ("radius_bits", "divided_to"))
    claim = read_orbit(contents["statement"])
    check_orbit(claim, zero_near(contents, tell))
    return _orbit_lines(claim, read_body(contents["scene"], ("level",)))


class Zero(NamedTuple):
    """The zero of F: state, period and residue as balls, in the scene's units.

    ``alone``: how far from it in omega, gamma and period no other orbit of the level passes;
    ``repeated``: why the period may not be the least one, empty where it is; ``run``: what proved
    it.
    """

    start: list[arb]
    period: arb
    residue: arb
    alone: list[arb]
    repeated: str
    run: Run


def zero_near(contents: Mapping[str, object], tell: Tell | None = None) -> Zero:
    """The zero that guesses prove, whatever is stated of it; raises NotProved, Damaged."""
    radius_bits = _whole(contents["radius_bits"], 1, MOST_BITS, "radius_bits")
    parts = _primes(_whole(contents["divided_to"], 0, MOST_PARTS, "divided_to"))
    guesses = read_guesses([contents[name] for name in Guesses._fields], more=len(parts))
    if guesses.grid[-1] < 0:
        raise Damaged("grid: expected a period that is positive")
    ctx.prec = guesses.bits + 2 * COARSE
    scene = read_body(contents["scene"], ("level",))
    inertia, torque, _ = balls_of(scene)
    level, run = scene[2], Run(guesses, inertia, torque)
    r = arb(2) ** -radius_bits
    begin = Set(
        [[arb(0), arb(0), *row] for row in _unit()], [[arb(0), r, *[arb(0)] * 6]] * 6, 2
    )  # x* alone, the box around it, D
    back: dict[int, list[arb]] = {}
    steep, waiting = arb(0), sorted(parts)  # the largest, whose part of the period is over first
    for stage in run.stages(begin, DERIVATIVES, tell):
        steep = steep.max(stage.step.steepness(run.body, stage.reach))
        while waiting and Fraction(run.grid[-1], waiting[-1]) <= stage.last:
            p = waiting.pop()
            back[p] = [row[1] for row in stage.at(Fraction(run.grid[-1], p))]
        end = stage.at(Fraction(stage.last)) if stage.last == run.grid[-1] else []
    ctx.prec = guesses.bits + COARSE  # radii may be smaller than 2^-bits
    period = dyadic(run.grid[-1], run.shift - run.time_bits)
    values = [2 * ball(level[0]) * run.rates[0] ** 2, ball(level[1]) * run.rates[0], ball(level[2])]
    zero, reached = _closed(run, end, period, r, values)
    steep = steep.max(steepness(slope(run.body, reached)))
    most = upper((period + 4 * r) * steep / (2 * arb.pi()))
    return zero._replace(repeated=_repeated(run, r, back, most))


def _repeated(run: Run, r: arb, back: Mapping[int, Sequence[arb]], most: arb) -> str:
    """Why the period may be several times the least one; ``back``: the box after a p-th of it."""
    if (most < MOST_PARTS) is not True:
        return "the orbit is too long for its least period to be decided"
    box = [x + arb(0, r) for x in run.centres[0]]
    for p in _primes(int(float(most)) + 1):
        if p not in back:
            return f"whether the period is {p} times the least one was not looked at"
        there = around(run.body, back[p], 4 * r / p)
        if not any(x.overlaps(y) is False for x, y in zip(box, there, strict=True)):
            return f"the period may be {p} times the least one"
    return ""


def derivative_of_f(
    run: Run, end: Table, r: arb, w: Sequence[Sequence[arb]], a: Sequence[arb]
) -> tuple[arb_mat, list[arb]]:
    """DF(Y), and where the motions of Y are when they end; ``w``: W by columns."""
    reached = around(run.body, [row[1] for row in end], 4 * r)
    later = drift(run.body, reached, 4 * r)
    speed, zero = rates(run.body, reached), [arb(0)] * 4
    rows = []
    for i, d in enumerate(around_in_time([row[2:] for row in end], later)):
        d[i] = d[i] - 1
        rows.append([*d, speed[i], *(-column[i] for column in w)])
    rows.append([*a, *zero])
    box = [y + arb(0, r) for y in run.centres[0]]
    return arb_mat(rows + [[*row, *zero] for row in gradients(run, box)]), reached


def drift(body: Body, reached: Sequence[arb], span: arb) -> arb:
    """A bound of |Phi - 1|, Phi the transition matrix of any part of a time within +- span."""
    return upper((span * row_sum(slope(body, reached))).expm1())


def around_in_time(rows: Table, later: arb) -> Table:
    """D at all times near one; ``later``: the drift between them."""
    sizes = [largest(column) for column in zip(*rows, strict=True)]
    return [
        [y + arb(0, upper(later * size)) for y, size in zip(row, sizes, strict=True)]
        for row in rows
    ]


def _closed(
    run: Run, end: Table, period: arb, r: arb, values: Sequence[arb]
) -> tuple[Zero, list[arb]]:
    """The theorem, and where the orbit is when it closes; raises NotProved.

    ``end``: of x*, of the box, and D, at T*.
    """
    certainly(r > 0, "the box is empty")
    certainly(period > 4 * r, "the period is no longer than its box")
    x, body = run.centres[0], run.body
    box = [y + arb(0, r) for y in x]
    w = [[(y / size).mid() for y in row] for row in gradients(run, x) for size in [largest(row)]]
    a = [y.mid() for y in rates(body, x)]
    df, reached = derivative_of_f(run, end, r, w, a)
    f = [row[0] - y for row, y in zip(end, x, strict=True)] + [arb(0)]
    f += [y - c for y, c in zip(integrals(run, x), values, strict=True)]
    c = inverse(df.mid(), "the ten equations are singular").mid()
    radii = [r] * 6 + [4 * r] * 4
    moved = krawczyk(c, df, f, radii)
    for name, y, radius in zip(UNKNOWN, moved, radii, strict=True):
        line = f"Krawczyk's test fails in {name}, by a factor {float(upper(y) / radius):.2g}"
        certainly(upper(y) < radius, line)
    hull = [
        y + arb(0, upper(4 * r * summed(upper(column[i]) for column in w)))
        for i, y in enumerate(box)
    ]
    determinant = (arb_mat(gradients(run, hull)) * arb_mat(w).transpose()).det()
    certainly(abs(determinant) > 0, "the gradients of h, f and |gamma|^2 may be dependent")
    there = rates(body, box)
    along = summed(y * z for y, z in zip(a, there, strict=True)).lower()
    certainly(along > 0, "the plane of the start may touch the motion")
    near = r / (1 + largest(there) * summed(map(abs, a)) / along) - largest(moved[:6])
    unit = run.rates[0]  # of a time, inverse
    return Zero(
        [(y + z) / rate for y, z, rate in zip(x, moved, run.rates, strict=False)],
        (period + moved[6]) * unit,
        -summed(df[i, i] for i in range(6)) / 4,
        [near / unit, near, (4 * r - upper(moved[6])) * unit],
        "",
        run,
    ), reached


def krawczyk(c: arb_mat, slopes: arb_mat, values: Sequence[arb], radii: Sequence[arb]) -> list[arb]:
    """K - y of a function with these values at y, and these slopes where |x - y| <= radii."""
    left, newton = c * slopes, (c * arb_mat([[x] for x in values])).entries()
    moved = []
    for i, x in enumerate(newton):
        size = summed(upper(left[i, j] - int(i == j)) * r for j, r in enumerate(radii))
        moved.append(arb(0, upper(size)) - x)
    return moved


def integrals(run: Run, x: Sequence[arb]) -> list[arb]:
    """H of a box."""
    w, g = x[:3], x[3:]
    momentum = _momentum(run, w)
    return [
        summed(momentum[i] * w[i] + 2 * run.torque[i] * g[i] for i in range(3)),
        summed(momentum[i] * g[i] for i in range(3)),
        summed(y * y for y in g),
    ]


def gradients(run: Run, x: Sequence[arb]) -> Table:
    """DH of a box, three rows of six."""
    momentum, inertial = _momentum(run, x[:3]), _momentum(run, x[3:])
    return [
        [2 * y for y in (*momentum, *run.torque)],
        [*inertial, *momentum],
        [*[arb(0)] * 3, *(2 * y for y in x[3:])],
    ]


def _momentum(run: Run, w: Sequence[arb]) -> list[arb]:
    return [summed(y * z for y, z in zip(row, w, strict=True)) for row in run.inertia]


def slope(body: Body, box: Sequence[arb]) -> Table:
    """f' of a box."""
    rows = [[arb(0)] * 6 for _ in range(6)]
    for (i, j), x in body.derivative([arb_poly([y]) for y in box]).items():
        rows[i][j] = x[0]
    return rows


def steepness(rows: Table) -> arb:
    """A bound of a matrix's Euclidean norm: the root of its row sum times its column sum."""
    return upper((row_sum(rows) * row_sum(list(zip(*rows, strict=True)))).sqrt())


def rates(body: Body, box: Sequence[arb]) -> list[arb]:
    """f of a box."""
    return body.field(box, lambda i, j: box[i] * box[j])


def around(body: Body, box: Sequence[arb], span: arb) -> list[arb]:
    """All that motions through a box reach within +- span.

    A box that is wider by span v, |f| < v in it, is not left sooner.
    """
    speed = 2 * largest(rates(body, box)) + arb(2) ** -100
    for _ in range(30):
        speed = upper(speed)
        wide = [x + arb(0, upper(span * speed)) for x in box]
        if (largest(rates(body, wide)) < speed) is True:
            return wide
        speed = 2 * speed
    raise NotProved("the motion near the period's end has no bound")


def check_orbit(claim: Orbit, zero: Zero) -> None:
    """Whether a zero is what is stated; raises NotProved."""
    for name, x, pair in zip(NAMES, zero.start, claim.start, strict=True):
        _inside(x, pair, f"{name} of the start")
    _inside(zero.period, claim.period, "the period")
    _inside(zero.residue, claim.residue, "the residue")
    certainly(STABILITY[claim.kind](zero.residue), f"that the orbit is {claim.kind}")
    for far, most in zip(claim.alone, zero.alone, strict=True):
        certainly(ball((far, Fraction(0))) <= most.lower(), "that no other orbit is so near")
    certainly(not (claim.least and zero.repeated), zero.repeated)


def _inside(x: arb, pair: Interval, name: str) -> None:
    middle, radius = (arb(fmpq(y.numerator, y.denominator)) for y in pair)
    certainly(abs(x - middle) <= radius, f"{name} is not shown to lie in its ball")


def _primes(last: int) -> list[int]:
    """Those up to a number, the largest first."""
    primes: list[int] = []
    for n in range(2, last + 1):
        if all(n % p for p in primes if p * p <= n):
            primes.append(n)
    return primes[::-1]


def _orbit_lines(claim: Orbit, scene: Scene) -> list[str]:
    word = "period" if not claim.least else "least period"
    inertia, torque, level = scene
    exact = not any(radius for _, radius in chain(*inertia, *torque))
    body = "this body" if exact else "every body in the scene's balls"
    h, f, square = (in_full(x) if not r else f"{in_full(x)} +- {in_full(r)}" for x, r in level)
    omega, gamma, period = (decimal(x, up=False, minus=False) if x else "0" for x in claim.alone)
    widest = rounded_up(max(radius for _, radius in claim.start))
    return [
        f"proved: on the level h = {h}, f = {f}, |gamma|^2 = {square} of {body} a periodic "
        f"orbit passes within {widest}, in each component, of the start that is stated; its "
        f"{word} lies within {rounded_up(claim.period[1])} of {about(claim.period)}; it is "
        f"{claim.kind} on its level, with a residue within {rounded_up(claim.residue[1])} of "
        f"{about(claim.residue)}",
        f"no other orbit of the level passes within {omega} (omega) and {gamma} (gamma) of the "
        f"point where this one does and has a period within {period} of this one",
    ]


def about(interval: Interval) -> str:
    """The middle as the certificate writes it, if it is a decimal; else the fraction."""
    x = interval[0]
    for places in range(MOST_DIGITS):
        if (x * 10**places).denominator == 1:
            text = str(fmpz(abs(x.numerator * 10**places // x.denominator))).rjust(places + 1, "0")
            return "-" * (x < 0) + (f"{text[:-places]}.{text[-places:]}" if places else text)
        if places > x.denominator.bit_length():
            break
    return in_full(x)


def in_full(x: Fraction) -> str:
    """A fraction of any size, which Python itself may refuse to print."""
    return str(fmpz(x.numerator)) + (f"/{fmpz(x.denominator)}" if x.denominator > 1 else "")


# -- a claim: stability -------------------------------------------------------------------------

#: *The return map.*  Let x0 be the point of an elliptic orbit in the plane a.(x - x0) = 0, where
#: a.f(x0) != 0, and xi two components of x - x0 for which the matrix [xi; a; DH](x0) is regular.
#: Then xi and c = H(x) are coordinates of the plane near x0, and what starts there returns after
#: about the period: xi -> P_c(xi), analytic in xi and c.  f has no divergence and H is constant, so
#: the flow preserves the form eta of each level for which eta dH_1 dH_2 dH_3 = dx, and P_c the form
#: b = i_f eta, as b is closed and i_f b = 0.  b is nowhere 0 on the plane, which f crosses: with
#: X = xi_1 and Y an integral of b's density over xi_2, P_c preserves the area dX dY, analytic in c.
#:
#: *Its normal form.*  Let mu, mu* = 1/mu be the eigenvalues of P', at xi = 0 and the orbit's c, and
#: q a complex eigenvector; xi = q z + q* z*; z -> mu z + sum f_jk z^j z*^k.  If mu^k != 1 for
#: k = 1, 2, 3, 4, new coordinates w = z + ... give mu w + c1 w^2 w* + O(|w|^4), with
#:
#:     c1 = f21 + f20 f11 (1 - 2 mu)/(mu^2 - mu) + |f11|^2/(1 - mu*) + 2 |f02|^2/(mu^2 - mu*).
#:
#: For z = w + sum h_jk w^j w*^k, h_jk = f_jk/(mu^j mu*^k - mu), leaves no square, and of the cubic
#: terms c1 = f21 + 2 f20 h11 + f11 (h11* + h20) + 2 f02 h02* that of w^2 w*.
#: No further change alters c1, and a factor s of z alters it by |s|^2.  In the coordinates X, Y it
#: is i beta mu with beta real; so mu* c1 = i beta here, too, but for a positive factor of beta.
#:
#: *Theorem.*  If beta != 0, the orbit is stable: for each d > 0 what starts near enough to it, on
#: any level, stays within d of it for all time, forward and back.  For mu is not 1, so the fixed
#: point goes on to all c near the orbit's, and all above is analytic in c.  With |w|^2 =
#: s^2 (1 + r) the map of the ring 0 <= r <= 1 is angle -> angle + theta + s^2 beta (1 + r) +
#: O(s^3), r -> r + O(s^3), in a complex neighbourhood that does not depend on s and c.  A curve
#: around 0 meets its image, which encloses the same area; and O(s^3) is as small a part of
#: s^2 beta as one likes.  So, for all small s, the ring contains an invariant curve, for all c near
#: the orbit's (J. Moser, Nachr. Akad. Wiss. Goettingen II (1962) 1; C. L. Siegel and J. K. Moser,
#: Lectures on Celestial Mechanics (1971), 31-34).  P_c and its inverse map what it encloses onto
#: itself.  What starts near the orbit reaches the plane near x0, inside that curve on its own
#: level; between two returns, which take about a period, it stays near the orbit, as it starts
#: near x0.
#:
#: *mu = i.*  Then d w*^3 stands beside c1 w^2 w*, with f03 + f11 h02 + 2 f02 h20* as
#:
#:     d = f03 + f11 f02/(mu*^2 - mu) + 2 f02 f20*/(mu*^2 - mu*),
#:
#: and |d|/|beta| is that in the coordinates X, Y.  There P^4 = 1 + 4 V + O(|w|^4), V the field of
#: K = beta |w|^4/2 - Re(d w*^4)/2.  If |d| < |beta|, K = kappa j^2 with kappa != 0 in its own
#: action j and angle, which P^4 turns by 8 kappa j + O(j^(3/2)); so Moser's theorem holds for P^4,
#: and, its condition being open, for P_c^4 on the levels near by.
#:
#: *Jets.*  P is computed with polynomials of xi whose terms above the third degree are forgotten:
#: an algebra, in which the equations and the expansion f(x + z) = f(x) + f'(x) z + B(z, z) hold as
#: they do for numbers.  Let z_m be the six coefficients of xi^m, |z| = sum_m rho^|m| |Q z_m|
#: (Euclid's norm), Q regular, A_m those of A, S the symmetric part of Q A_0 Q^-1.  On a step
#:
#:     |z|' <= (|S| + n) |z| + |h| beta' |z|^2 + |d|,    n = sum_(m != 0) rho^|m| |Q A_m Q^-1|,
#:
#: where |S| (Frobenius) is above the largest eigenvalue of S, and beta' = beta u v^2, u the sum of
#: |Q_ij| and v the largest row sum of |Q^-1|.  So, with g = exp int (|S| + n), delta >= int |d| and
#: g (eps + delta + |h| beta' r^2) < r, |z(0)| <= eps gives |z| < r on the whole step.  The last one
#: ends at the period, a ball; there the orbit itself is in x0.
#:
#: *The numbers.*  The rotation is theta/(2 pi), 0 < theta < pi.  The twist is the derivative of the
#: angle by the action, the canonical area over 2 pi; the canonical area of two changes of
#: G = I w and g = gamma is (dg x g).dG'/|g|^2 - (dg' x g).dG/|g|^2 + f g.(dg x dg')/|g|^4.  For
#: with the turns al = (dg x g)/|g|^2, of which dg = g x al and al.g = 0, the form d(G.al) of the
#: rotations is al.dG' - al'.dG + G.(al x al'), and al x al' = g (g.(dg x dg'))/|g|^4.
DEGREE = 3
MONOMIALS = [(d - n, n) for d in range(DEGREE + 1) for n in range(d + 1)]
FACTORS = [
    [
        (MONOMIALS.index((i, j)), MONOMIALS.index((a - i, b - j)))
        for i in range(a + 1)
        for j in range(b + 1)
    ]
    for a, b in MONOMIALS
]
MOST_WEIGHT = 200  # bits of 1/rho
OF_JETS = 6  # steps, with their sets, that cost as much as one of jets at 96 bits


class Jet(Generic[Y]):
    """A polynomial of two variables, by its coefficients in the order of MONOMIALS."""

    def __init__(self, parts: Iterable[Y]) -> None:
        self.parts = [*parts]

    def __add__(self, other: Jet[Y]) -> Jet[Y]:
        return Jet(x + y for x, y in zip(self.parts, other.parts, strict=True))

    def __sub__(self, other: Jet[Y]) -> Jet[Y]:
        return Jet(x - y for x, y in zip(self.parts, other.parts, strict=True))

    def __mul__(self, other: Jet[Y] | Y | arb) -> Jet[Y]:
        if not isinstance(other, Jet):
            return Jet(x * other for x in self.parts)
        zero = self.parts[0] * arb(0)
        return Jet(
            sum((self.parts[i] * other.parts[j] for i, j in pairs), zero) for pairs in FACTORS
        )

    def at(self, origin: Y) -> Jet[Y]:
        """The jet with another constant term."""
        jet = Jet(self.parts)
        jet.parts[0] = origin
        return jet


def jet(*parts: Y) -> Jet[Y]:
    """The jet of some first coefficients; the others are 0."""
    zeros = [parts[0] * arb(0) for _ in MONOMIALS[len(parts) :]]
    return Jet(chain(parts, zeros))


def _dot(row: Iterable[Jet[arb]], column: Iterable[Jet[arb] | arb]) -> Jet[arb]:
    return sum((x * y for x, y in zip(row, column, strict=True)), jet(arb(0)))


class Norm:
    """The norm of six jets: Q, rho, and bounds between |z| and the coefficients of z."""

    def __init__(self, run: Run, weight_bits: int) -> None:
        self.algebra = Algebra(FACTORS, [weight_bits * (a + b) for a, b in MONOMIALS])
        self.weights = [arb(2) ** -n for n in self.algebra.shifts]
        self.q = arb_mat(_frame_of(run))
        self.inverse = self.q.inv()
        self.into = [upper(summed(map(upper, x))) for x in self.q.transpose().table()]
        self.out_of = [upper(summed(map(upper, x))) for x in self.inverse.table()]

    def of(self, rows: Sequence[Sequence[arb]]) -> arb:
        """A bound of |z|, from bounds of its coefficients."""
        sizes = [summed(map(mul, row, self.weights)) for row in rows]
        return upper(summed(map(mul, sizes, self.into)))

    def around(self, rows: Sequence[Jet[arb]], eps: arb) -> list[Jet[arb]]:
        """All jets within eps of some."""
        return [
            Jet(
                x + arb(0, upper(by * eps / weight))
                for x, weight in zip(row.parts, self.weights, strict=True)
            )
            for row, by in zip(rows, self.out_of, strict=True)
        ]

    def growth(self, body: Body, p: Sequence[Jet[arb_poly]], h: arb) -> arb:
        """A bound of g, the exponential of int (|S| + n)."""
        slopes = [body.derivative([row.parts[m] for row in p]) for m in range(len(MONOMIALS))]
        sizes = []
        for a in matrices_of(slopes[0], h):
            in_frame = self.q * a * self.inverse
            s = (in_frame + in_frame.transpose()) / 2
            sizes.append(upper((s * s.transpose()).trace()).sqrt())
        rest = summed(
            integral(map(upper, (x * h).coeffs())) * weight * self.into[i] * self.out_of[j]
            for weight, slope_of_m in zip(self.weights[1:], slopes[1:], strict=True)
            for (i, j), x in slope_of_m.items()
            if not i < 3 <= j  # the torque's entries, which are constant
        )
        return upper((integral(sizes) + rest).exp())


def _frame_of(run: Run) -> Table:
    """Q, exact; any regular matrix would do.

    Of omega a multiple of Cholesky's factor of the inertia, so that a turn keeps the norm.  The
    largest moment is the unit of mass.
    """
    unit_of_mass = largest(run.inertia[i][i] for i in range(3))
    inertia = [[float(x / unit_of_mass) for x in row] for row in run.inertia]
    root = [[0.0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(i + 1):
            left = inertia[i][j] - sum(map(mul, root[i], root[j]))
            root[i][j] = max(left, 1e-9) ** 0.5 if i == j else left / root[j][j]
    swing = max(abs(float(x / unit_of_mass)) for x in run.torque)
    rate = max(abs(float(x)) for row in run.centres for x in row[:3]) / 8
    unit = max(swing, rate**2, 1e-9) ** -0.5
    rows = [[arb(unit * root[j][i]) for j in range(3)] + [arb(0)] * 3 for i in range(3)]
    return rows + _unit()[3:]


def jet_step(
    body: Body, centre: Sequence[Jet[arb]], eps: arb, time: tuple[arb, arb], norm: Norm, bits: int
) -> tuple[list[Jet[arb]], arb]:
    """Exact jets, and how far from them a step may take all that is within eps of a centre.

    ``time``: the step's length, and a ball of the part of it that passes.  Raises NotProved.
    """
    ctx.prec, (h, tau) = bits, time
    guess = taylor_over(norm.algebra, body, [row.parts for row in centre], h, bits)
    p = [
        Jet(arb_poly([x, *more]) for x, more in zip(row.parts, rows, strict=True))
        for row, rows in zip(centre, guess, strict=True)
    ]
    rates = body.field(p, cache(lambda i, j: p[i] * p[j]))
    defect = [
        [(x.derivative() - rate * h).coeffs() for x, rate in zip(*pair, strict=True)]
        for pair in zip([row.parts for row in p], [row.parts for row in rates], strict=True)
    ]
    there = [[x(tau) for x in row.parts] for row in p]
    ctx.prec = COARSE
    delta = norm.of([[integral(map(upper, x)) for x in row] for row in defect])
    growth = norm.growth(body, p, h)
    beta = upper(h) * body.beta * summed(norm.into) * largest(norm.out_of) ** 2
    r = upper(2 * growth * (eps + delta)) + arb(2) ** -100_000
    reach = upper(growth * (eps + delta + beta * r * r))
    certainly(reach < r, "the condition of the step")
    rounded = norm.of([[upper(x.rad()) for x in row] for row in there])
    return [Jet(x.mid() for x in row) for row in there], upper(reach + rounded)


class Guide(NamedTuple):
    """How jets are computed: their bits, and those of 1/rho."""

    jet_bits: int
    weight_bits: int


class Twist(NamedTuple):
    """Of the return map: its angle at the orbit, in turns, and that angle's slope by the action."""

    rotation: arb
    twist: arb


def twist_of(zero: Zero, guide: Guide, tell: Tell | None = None) -> Twist:
    """What the return map of an orbit is to the third degree; raises NotProved."""
    run, count = zero.run, len(zero.run.centres)
    ctx.prec = fine = max(run.bits, guide.jet_bits) + COARSE
    x0 = [x * rate for x, rate in zip(zero.start, run.rates, strict=True)]
    period = zero.period / run.rates[0]
    a = [x.mid() for x in rates(run.body, run.centres[0])]
    places, begin = _chart_at(run, x0, a)
    centre = [Jet(x.mid() for x in row.parts) for row in begin]
    ctx.prec = COARSE
    norm = Norm(run, guide.weight_bits)
    eps = norm.of([[upper(x.rad()) for x in row.parts] for row in begin])
    for n, (first, last) in enumerate(pairwise(run.grid)):
        if tell is not None:
            tell(n / count, n)
        ctx.prec = fine
        h, tau = dyadic(last - first, run.shift - run.time_bits), arb(1)
        if n + 1 == count:
            left = period - dyadic(first, run.shift - run.time_bits)
            certainly(left > 0, "the last step is no longer than the period's ball")
            h, tau = left.upper(), left / left.upper()
        try:
            centre, eps = jet_step(run.body, centre, eps, (h, tau), norm, guide.jet_bits)
        except NotProved as fault:
            raise NotProved(f"jets, step {n + 1} of {count}: {fault}") from None
    ctx.prec = fine
    end = [row.at(x) for row, x in zip(norm.around(centre, eps), x0, strict=True)]
    image = _crossed(run.body, a, end)
    mu, q, beta = normal_form([image[n].parts for n in places])
    area = _canonical_area(run, x0, *([row.parts[m] for row in begin] for m in (1, 2)))
    action = 2 * abs(area * (q[0] * q[1].conjugate()).imag) / run.rates[0]  # of |z| = 1
    certainly(action > 0, "the action has no bound")
    return Twist(mu.real.acos() / (2 * arb.pi()), beta / action)


def _chart_at(
    run: Run, x0: Sequence[arb], a: Sequence[arb]
) -> tuple[tuple[int, ...], list[Jet[arb]]]:
    """Which components xi are, and x(xi) on the plane and the level; raises NotProved.

    H(x0 + u) - H(x0) is DH u and what is quadratic in u.
    """
    fixed, unit = [a, *gradients(run, x0)], _unit()
    frames = {
        pair: arb_mat([*(unit[n] for n in pair), *fixed]) for pair in combinations(range(6), 2)
    }
    places = max(frames, key=lambda pair: abs(float(frames[pair].det().mid())))
    rows = inverse(frames[places], "the plane of the start may touch the motion").table()
    zero, unity = arb(0), arb(1)
    u = [jet(zero)] * 6
    for _ in range(DEGREE):  # each time right to one degree more
        momentum = [_dot(u[:3], row) for row in run.inertia]
        pairs = (momentum, u[:3]), (momentum, u[3:]), (u[3:], u[3:])
        curved = [_dot(*pair) * -unity for pair in pairs]
        values = [jet(zero, unity), jet(zero, zero, unity), jet(zero), *curved]
        u = [_dot(values, row) for row in rows]
    return places, [row.at(x) for row, x in zip(u, x0, strict=True)]


def _crossed(body: Body, a: Sequence[arb], start: Sequence[Jet[arb]]) -> list[Jet[arb]]:
    """Where what starts near x0 meets the plane through it, less x0, the constant terms of start.

    Raises NotProved.
    """
    series = [[*start]]
    for k in range(DEGREE):

        def product(i: int, j: int, k: int = k) -> Jet[arb]:
            return _dot([row[i] for row in series], [series[k - n][j] for n in range(k + 1)])

        series.append([x * (arb(1) / (k + 1)) for x in body.field(series[k], product)])
    series[0] = [x.at(arb(0)) for x in start]
    off = [_dot(row, a) for row in series]
    speed, tau = off[1].parts[0], jet(arb(0))
    certainly(abs(speed) > 0, "the plane of the start may touch the motion")

    def at_tau(rows: Sequence[Jet[arb]]) -> Jet[arb]:
        value = rows[-1]
        for row in rows[-2::-1]:
            value = row + value * tau
        return value

    for _ in range(DEGREE):  # each time right to one degree more
        tau = tau - at_tau(off) * (1 / speed)
    return [at_tau(rows) for rows in zip(*series, strict=True)]


def _canonical_area(
    run: Run, x0: Sequence[arb], first: Sequence[arb], second: Sequence[arb]
) -> arb:
    """Of two changes of the state x0 along its level."""
    gamma, square = x0[3:], _product(x0[3:], x0[3:])
    area = _product(_cross(first[3:], gamma), _momentum(run, second[:3]))
    area -= _product(_cross(second[3:], gamma), _momentum(run, first[:3]))
    f = _product(_momentum(run, x0[:3]), gamma)
    return area / square + f * _product(gamma, _cross(first[3:], second[3:])) / square**2


def _cross(x: Sequence[arb], y: Sequence[arb]) -> list[arb]:
    return [x[i - 2] * y[i - 1] - x[i - 1] * y[i - 2] for i in range(3)]


def normal_form(p: Sequence[Sequence[arb]]) -> tuple[acb, list[acb], arb]:
    """mu, q and beta of a map from the coefficients of its two components; raises NotProved."""
    (a, b), (c, d) = (row[1:3] for row in p)
    trace = a + d
    certainly(abs(trace) < 2, "that the orbit is elliptic")
    certainly(abs(trace + 1) > 0, "the residue may be 3/4: a resonance of the third order")
    mu = acb(trace / 2, (1 - trace * trace / 4).sqrt())
    bar, q = mu.conjugate(), [acb(b), mu - a]  # b c = -|mu - a|^2 < 0
    q_bar = [x.conjugate() for x in q]
    f = _in_eigenvectors(p, q, q_bar)
    f20, f11, f02, f02_bar = f[2, 0], f[1, 1], f[0, 2], f[0, 2].conjugate()
    c1 = f[2, 1] + f20 * f11 * (1 - 2 * mu) / (mu * mu - mu) + f11 * f11.conjugate() / (1 - bar)
    c1 += 2 * f02 * f02_bar / (mu * mu - bar)
    i_beta = bar * c1
    if not ((a * d - b * c).contains(1) and i_beta.real.contains(0)):
        raise NotProved("the return map preserves no area")  # which would be this file's fault
    if not abs(trace) > 0:
        resonant = f[0, 3] + f11 * f02 / (bar * bar - mu)
        resonant += 2 * f02 * f20.conjugate() / (bar * bar - bar)
        line = "the residue may be 1/2: a resonance of the fourth order, of which a term is large"
        certainly(abs(resonant) < abs(i_beta.imag), line)
    return mu, q, i_beta.imag


def _in_eigenvectors(
    p: Sequence[Sequence[arb]], q: Sequence[acb], q_bar: Sequence[acb]
) -> dict[tuple[int, int], acb]:
    """The coefficients of z^j z*^k in the map of z, where xi = q z + q* z*."""
    xi = [jet(acb(0), *pair) for pair in zip(q, q_bar, strict=True)]
    powers = {(0, 0): jet(acb(1))}
    for i, j in MONOMIALS[1:]:
        powers[i, j] = powers[i - 1, j] * xi[0] if i else powers[i, j - 1] * xi[1]
    size = q[0] * q_bar[1] - q[1] * q_bar[0]
    terms = zip(MONOMIALS, *p, strict=True)
    image = [powers[m] * ((x * q_bar[1] - y * q_bar[0]) / size) for m, x, y in terms]
    return dict(zip(MONOMIALS, sum(image, jet(acb(0))).parts, strict=True))


def stability(certificate: object, tell: Tell | None = None) -> list[str]:
    """What a certificate of stability proves; raises NotProved, Damaged."""
    contents = _contents(certificate, ("radius_bits", "divided_to", *Guide._fields))
    claim, balls = read_stability(contents["statement"])
    guide = read_guide(contents)
    zero = zero_near(contents, tell and (lambda part, steps: tell(part / OF_JETS, steps)))
    check_orbit(claim, zero)
    rest = 1 - 1 / OF_JETS
    check_twist(balls, twist_of(zero, guide, tell and (lambda x, n: tell(1 - rest + rest * x, n))))
    far = [rounded_up(radius) for _, radius in balls]
    return [
        *_orbit_lines(claim, read_body(contents["scene"], ("level",))),
        "it is stable for all time, forward and back: for each d > 0 a motion of omega and gamma "
        "of this body that starts near enough to the orbit, on its level or another, stays within "
        f"d of it; its rotation lies within {far[0]} of {about(balls[0])} of a turn, its twist "
        f"within {far[1]} of {about(balls[1])}",
    ]


def read_stability(statement: object) -> tuple[Orbit, list[Interval]]:
    """What is stated of the orbit, and the balls of rotation and twist; raises Damaged."""
    names = (*Orbit._fields, *Twist._fields)
    values = dict(zip(names, _keys(statement, names, "statement"), strict=True))
    balls = [_interval(values.pop(name), f"statement.{name}") for name in Twist._fields]
    claim = read_orbit(values)
    if claim.kind != "elliptic":
        raise Damaged("statement.kind: expected elliptic")
    return claim, balls


def read_guide(contents: Mapping[str, object]) -> Guide:
    """How the jets of a certificate are computed; raises Damaged."""
    jet_bits = _whole(contents["jet_bits"], LEAST_BITS, MOST_BITS, "jet_bits")
    weight_bits = _whole(contents["weight_bits"], 0, MOST_WEIGHT, "weight_bits")
    products = sum(map(len, FACTORS))  # of numbers, in one of jets
    check_work(products * len(_list(contents["grid"], None, "grid")), jet_bits)
    return Guide(jet_bits, weight_bits)


def check_twist(claim: Sequence[Interval], twist: Twist) -> None:
    """Whether rotation and twist are those stated, and the twist is not 0; raises NotProved."""
    certainly(abs(twist.twist) > 0, "the twist may be 0")
    _inside(twist.rotation, claim[0], "the rotation")
    _inside(twist.twist, claim[1], "the twist")
    middle, radius = claim[1]
    certainly(abs(middle) > radius, "the stated twist may be 0")


# -- a claim: chaos -----------------------------------------------------------------------------
#
# A chart is a point c, matrices E (6 x 2) and K (6 x 4), a covector a and eta > 0, all exact.  Of a
# rectangle R of y, |y_1 - middle| <= width, |y_2| <= height, the set is
#
#     N = {c + E y + K n(y): y in R},   n(y) the only |n| <= eta with H(x) = level, a(x - c) = 0,
#
# which exists by Krawczyk's test for all y at once; n' = -(G_n)^-1 G_y, G those four equations.
# The motions of N are carried on to a time t as m + sum_k T_k xi_k, |xi_k| <= 1, xi_1 and xi_2
# being the coordinates of R over its sizes.  Let S hold all that they reach within +- d of t.
# Where a' f keeps its sign on S, |a' f| >= low there and |a'(x - c')| <= low d at t, each motion
# meets the plane of the next chart exactly once within +- d, in
#
#     (y', n') = [E' | K']^-1 (1 - f a' / (a' f)) (x - c'),   f a mean of f over S,
#
# and dy'/dy is that matrix, f in S, times D (E + K n'), D the derivative of the flow.  N covers N'
# if |y'_2| < height' on N, |n'| < eta' on N, and y'_1 of the edges xi_1 = +-1 lies beyond the edges
# of N' on opposite sides (P. Zgliczynski and M. Gidea, J. Differential Equations 202 (2004)).  The
# cone condition: L^T Q L - Q is positive definite, L = dy'/dy in units of the sizes, Q = (1, -1)
# (H. Kokubu, D. Wilczak and P. Zgliczynski, Nonlinearity 20 (2007)).
#
# Theorem.  N0 and M1 are disjoint sets of one chart, N0 covers both by one section map, and
# M1, ..., Mk, N0 cover each the next, all with cones.  Then every path of that graph is followed by
# a motion, a periodic path by a periodic one, a path without ends by exactly one; N0 N0 ... M1 ...
# Mk N0 N0 ... by a transversal homoclinic one.  The point in N0 tells which set comes next, so the
# entropy of the flow on the level is at least the x > 0 with exp(-x t_0) + exp(-x t_1) = 1, t_0 an
# upper bound of the time from N0 to N0, t_1 of that along the loop.
#
# By the cones N0 contains one periodic orbit that returns by that map.  A motion that meets the
# plane in N0, and comes back to the same point after a time within +- d of t, is the one.

MOST_SETS = 500
MOST_SCALE = 2000  # bits of a chart's numbers
CHART = {"centre": (6, 1), "wide": (6, 2), "deep": (6, 4), "plane": (6, 1), "eta": (1, 1)}


class Chart(NamedTuple):
    """A chart in the units of a run."""

    centre: list[arb]
    wide: arb_mat
    deep: arb_mat
    plane: list[arb]
    eta: arb


class Rectangle(NamedTuple):
    """A set: the number of its chart, and its sizes."""

    chart: int
    middle: arb
    width: arb
    height: arb


class Image(NamedTuple):
    """(y', n') of a set, shift + sum of columns; dy'/dy; bounds of the time, in the run's unit."""

    shift: list[arb]
    columns: Table
    slope: arb_mat
    least: arb
    most: arb


class Margins(NamedTuple):
    """Of a covering: the edges over the width, the height over the height; of the cones."""

    stretch: arb
    height: arb
    cone: arb


class Horseshoe(NamedTuple):
    """What the sets prove: upper bounds of the times of both loops, in the scene's unit.

    ``home``: the run, the chart and the set that the periodic orbit meets.
    """

    short: arb
    long: arb
    images: list[Image]
    margins: list[Margins]
    home: tuple[Run, Chart, Rectangle]


class Entropy(NamedTuple):
    """What is stated of chaos: a lower bound, and upper ones of the times of both loops."""

    entropy: Fraction
    short: Fraction
    long: Fraction


def read_chaos(statement: object) -> Entropy:
    """The statement of a certificate of chaos; raises Damaged."""
    names = Entropy._fields
    values = zip(_keys(statement, names, "statement"), names, strict=True)
    claim = Entropy(*(_rational(x, f"statement.{name}") for x, name in values))
    if not min(claim) > 0:
        raise Damaged("statement: expected numbers above 0")
    return claim


def chaos(certificate: object, tell: Tell | None = None) -> list[str]:
    """What a certificate of chaos proves; raises NotProved, Damaged."""
    names = ("format", "kind", "scene", "bits", "scale", "charts", "sets", "transits", "statement")
    contents = dict(zip(names, _keys(certificate, names, "the certificate"), strict=True))
    claim = read_chaos(contents["statement"])
    proof = horseshoe(contents, tell)
    check_chaos(claim, proof)
    level = read_body(contents["scene"], ("level",))[2]
    h, f, square = (in_full(x) if not r else f"{in_full(x)} +- {in_full(r)}" for x, r in level)
    return [
        f"proved: on the level h = {h}, f = {f}, |gamma|^2 = {square} of this body an unstable "
        "periodic orbit has a transversal homoclinic orbit; for every sequence of two loops, "
        f"shorter than {about((claim.short, claim.short))} and "
        f"{about((claim.long, claim.long))}, exactly one motion follows it, a periodic one if the "
        "sequence is periodic; the topological entropy of the motion on the level is at least "
        f"{decimal(claim.entropy, up=False, minus=False)}",
        f"by {len(proof.margins)} covering relations with cone conditions between "
        f"{len(proof.images)} sets",
    ]


def horseshoe(contents: Mapping[str, object], tell: Tell | None = None) -> Horseshoe:
    """What sets and charts prove, whatever is stated of them; raises NotProved, Damaged."""
    bits = _whole(contents["bits"], LEAST_BITS, MOST_BITS, "bits")
    scale = _whole(contents["scale"], 1, MOST_SCALE, "scale")
    ctx.prec = bits + 2 * COARSE
    charts = [
        _chart_numbers(x, f"charts[{n}]")
        for n, x in enumerate(_list(contents["charts"], None, "charts"))
    ]
    if not charts:
        raise Damaged("charts: expected at least one")
    sets = [
        _rectangle(x, scale, len(charts), f"sets[{n}]")
        for n, x in enumerate(_list(contents["sets"], None, "sets"))
    ]
    if not 2 <= len(sets) <= MOST_SETS:
        raise Damaged(f"sets: expected 2 to {MOST_SETS}")
    transits = [
        _transit(x, bits, f"transits[{n}]")
        for n, x in enumerate(_list(contents["transits"], len(sets), "transits"))
    ]
    check_work(sum(len(transit.grid) for transit in transits), bits)
    scene = read_body(contents["scene"], ("level",))
    home, first = sets[:2]
    certainly(home.chart == first.chart, "the first two sets are not of one section map")
    gap = abs(home.middle - first.middle) - home.width - first.width
    certainly(gap > 0, "the first two sets may meet")
    inertia, torque, _ = balls_of(scene)
    level, images, margins, times, places = scene[2], [], [], [], []
    for n, (source, transit) in enumerate(zip(sets, transits, strict=True)):
        tell_set = None if tell is None else _part(tell, n, len(sets))
        ctx.prec = bits + 2 * COARSE
        run, after = Run(transit, inertia, torque), (n + 1) % len(sets)
        here, there = (_chart(charts[k], scale, run) for k in (source.chart, sets[after].chart))
        try:
            images.append(_image(run, level, source, here, there, tell_set))
        except NotProved as fault:
            raise NotProved(f"set {n}: {fault}") from None
        for k in [0, 1] if n == 0 else [after]:
            line = f"set {n} over set {k}"
            margins.append(covers(images[-1], source, sets[k], there.eta, line))
        times.append(upper(images[-1].most * run.rates[0]))
        places.append((run, here, source))
    return Horseshoe(times[0], upper(summed(times)), images, margins, places[0])


def check_chaos(claim: Entropy, proof: Horseshoe) -> None:
    """Whether a horseshoe is what is stated; raises NotProved."""
    certainly(proof.short <= ball((claim.short, Fraction(0))), "the short loop may take longer")
    certainly(proof.long <= ball((claim.long, Fraction(0))), "the long loop may take longer")
    x = ball((claim.entropy, Fraction(0)))
    sum_of_both = (-x * proof.short).exp() + (-x * proof.long).exp()
    certainly(sum_of_both > 1, "the entropy is not shown to be as large")


def is_orbit_of(proof: Horseshoe, start: Sequence[arb], period: arb) -> None:
    """Whether a motion with a period is the periodic one of the first set; raises NotProved.

    ``start``, ``period``: balls in the scene's units.  In the times within which the first image
    meets the plane every motion meets it once, so that one that meets it in the set, and after such
    a time in the same point, is a fixed point of the section map; with cones there is one.
    """
    run, chart, rectangle = proof.home
    ctx.prec = run.bits + COARSE
    box = [x * rate for x, rate in zip(start, run.rates, strict=True)]
    off = _product(chart.plane, [x - c for x, c in zip(box, chart.centre, strict=True)])
    reached = _crossing(run.body, chart.plane, box, upper(off))[1]
    column = arb_mat([[x - c] for x, c in zip(reached, chart.centre, strict=True)])
    y1, y2, *deep = (_frame(chart) * column).entries()
    line = "the periodic orbit is not shown to pass through the first set"
    certainly(abs(y1 - rectangle.middle) < rectangle.width, line)
    certainly(abs(y2) < rectangle.height, line)
    for x in deep:
        certainly(abs(x) < chart.eta, line)
    time, image = period / run.rates[0], proof.images[0]
    line = "the period of the orbit is not shown to be a time of the short loop"
    certainly(image.least < time, line)
    certainly(time < image.most, line)


def _part(tell: Tell, n: int, count: int) -> Tell:
    return lambda part, steps: tell((n + part) / count, steps)


def _chart_numbers(value: object, where: str) -> list[list[list[int]]]:
    """The integers of a chart; raises Damaged."""
    parts = zip(_keys(value, tuple(CHART), where), CHART.items(), strict=True)
    return [_rows(part, *shape, f"{where}.{name}") for part, (name, shape) in parts]


def _transit(value: object, bits: int, where: str) -> Guesses:
    names = Guesses._fields[:-1]
    guesses = read_guesses([*_keys(value, names, where), bits], f"{where}.")
    if guesses.grid[-1] < 0:
        raise Damaged(f"{where}.grid: expected a time that is positive")
    return guesses


def _chart(numbers: list[list[list[int]]], scale: int, run: Run) -> Chart:
    """A chart in the units of a run; exact, for these differ by a power of 2."""
    centre, wide, deep, plane, eta = (
        [[dyadic(x, -scale) for x in row] for row in part] for part in numbers
    )
    certainly(eta[0][0] > 0, "a chart has no depth")

    def scaled(rows: Table) -> Table:
        return [[x * rate for x in row] for row, rate in zip(rows, run.rates, strict=True)]

    return Chart(
        [x for (x,) in scaled(centre)],
        arb_mat(scaled(wide)),
        arb_mat(scaled(deep)),
        [x / rate for (x,), rate in zip(plane, run.rates, strict=True)],
        eta[0][0],
    )


def _rectangle(value: object, scale: int, charts: int, where: str) -> Rectangle:
    names = Rectangle._fields
    chart, *sizes = _keys(value, names, where)
    middle, width, height = (
        dyadic(_long(x, f"{where}.{name}"), -scale)
        for x, name in zip(sizes, names[1:], strict=True)
    )
    if not (width > 0 and height > 0):
        raise Damaged(f"{where}: expected sizes above 0")
    return Rectangle(_whole(chart, 0, charts - 1, f"{where}.chart"), middle, width, height)


def _product(row: Sequence[arb], column: Sequence[arb]) -> arb:
    return summed(x * y for x, y in zip(row, column, strict=True))


def _disk(
    run: Run, level: Sequence[Interval], source: Rectangle, chart: Chart
) -> tuple[list[arb], arb_mat]:
    """All n(y) of a set as balls, and n'; raises NotProved where the set is no disk."""
    c, e, k = chart.centre, chart.wide, chart.deep
    values = [2 * ball(level[0]) * run.rates[0] ** 2, ball(level[1]) * run.rates[0], ball(level[2])]
    y = arb_mat([[source.middle + arb(0, upper(source.width))], [arb(0, upper(source.height))]])
    from_0 = arb(0, upper(source.middle) + upper(source.width))
    flat = _moved(c, e * arb_mat([[from_0], [y[1, 0]]]))
    along = e * y
    # H at E y is that at c and a mean of DH E, which is small, times y
    rise = (arb_mat([*gradients(run, flat), chart.plane]) * e * y).entries()
    value = [h - v for h, v in zip(integrals(run, c), values, strict=True)]
    value = [x + z for x, z in zip([*value, arb(0)], rise, strict=True)]
    radii = [upper(chart.eta)] * 4
    passed, at_middle = False, None
    for _ in range(4):
        points = _moved(_moved(c, along), k * arb_mat([[arb(0, r)] for r in radii]))
        left = arb_mat([*gradients(run, points), chart.plane])
        by_n = left * k
        if at_middle is None:
            at_middle = inverse(by_n.mid(), "a plane may touch the level").mid()
        depth = krawczyk(at_middle, by_n, value, radii)
        if not passed:
            for x, r in zip(depth, radii, strict=True):
                certainly(upper(x) < r, "a set is no graph over its rectangle")
            passed = True
        radii = [upper(x) + arb(2) ** -900 for x in depth]
    slope_of_n = -(inverse(by_n, "a set's slope has no bound") * left * e)
    speed = _product(chart.plane, rates(run.body, points))
    certainly(abs(speed) > 0, "a set's plane may touch the motion")
    return depth, slope_of_n


def _moved(point: Sequence[arb], by: arb_mat) -> list[arb]:
    return [x + by[i, 0] for i, x in enumerate(point)]


def _starts(run: Run, source: Rectangle, chart: Chart, depth: Sequence[arb]) -> Set:
    """The set's starts about the run's first centre, and D."""
    ctx.prec = run.bits
    sizes = [source.width, source.height, *(upper(x - x.mid()) for x in depth)]
    begin = _moved(chart.centre, chart.wide * arb_mat([[source.middle], [arb(0)]]))
    begin = _moved(begin, chart.deep * arb_mat([[x.mid()] for x in depth]))
    off = [x - y for x, y in zip(begin, run.centres[0], strict=True)]
    frame = [
        [*wide, *deep] for wide, deep in zip(chart.wide.table(), chart.deep.table(), strict=True)
    ]
    directions = [[x * size for x, size in zip(row, sizes, strict=True)] for row in frame]
    ctx.prec = COARSE
    lost = [
        upper(summed([x.rad(), *(y.rad() for y in row)]))
        for x, row in zip(off, directions, strict=True)
    ]
    zero = [arb(0)] * 6
    starts = Set([[x.mid(), *row] for x, row in zip(off, _unit(), strict=True)], [], 1)
    starts.s = [
        [*(y.mid() for y in row), *more] for row, more in zip(directions, _unit(), strict=True)
    ]
    starts.w = [[arb(1), *zero]] * 6 + [[x, *zero] for x in lost]
    starts.old = 12
    return starts


def _image(
    run: Run,
    level: Sequence[Interval],
    source: Rectangle,
    chart: Chart,
    target: Chart,
    tell: Tell | None,
) -> Image:
    """The image of a set in the plane of a chart; raises NotProved."""
    ctx.prec = run.bits
    depth, slope_of_n = _disk(run, level, source, chart)
    for stage in run.stages(_starts(run, source, chart, depth), SETS, tell):
        last = stage
    end = last.at(Fraction(last.last))
    middle, v = last.step.at(arb(1))
    moved, rows, left = last.before.carried(v, last.noise)
    ctx.prec = run.bits
    off = [x + row[0] - c for x, row, c in zip(middle, moved, target.centre, strict=True)]
    columns = [
        [row[k] * weight[0] for row in rows] for k, weight in enumerate(last.before.w)
    ]  # T_k
    columns += [[left[i][0] if i == j else arb(0) for j in range(6)] for i in range(6)]
    a, body = target.plane, run.body
    far = upper(_product(a, off)) + summed(upper(_product(a, x)) for x in columns)
    span, reached = _crossing(body, a, [row[0] for row in end], far)
    time = dyadic(run.grid[-1], run.shift - run.time_bits)
    certainly(time > span, "a transit may take no time")
    f = rates(body, reached)
    across, frame = _product(a, f), _frame(target)
    shadow = arb_mat([[x * y / across for y in a] for x in f])
    into = frame - frame * shadow
    d = arb_mat(around_in_time([row[1:] for row in end], drift(body, reached, span)))
    slope_of_y = into * d * (chart.wide + chart.deep * slope_of_n)
    return Image(
        (into * arb_mat([[x] for x in off])).entries(),
        [(into * arb_mat([[x] for x in column])).entries() for column in columns],
        slope_of_y,
        (time - span).lower(),
        upper(time + span),
    )


def _crossing(body: Body, a: Sequence[arb], box: Sequence[arb], far: arb) -> tuple[arb, list[arb]]:
    """d and S, for motions in a box of which |a (x - c)| <= far; raises NotProved."""
    rate = abs(_product(a, rates(body, box)))
    certainly(rate > 0, "a plane may touch the motion")
    span = upper(arb(3) / 2 * upper(far) / rate.lower()) + arb(2) ** -100
    reached = around(body, box, span)
    across = abs(_product(a, rates(body, reached)))
    certainly(across > 0, "a plane may touch the motion")
    certainly(upper(far) <= across.lower() * span, "a set may miss the next plane")
    return span, reached


def _frame(chart: Chart) -> arb_mat:
    """The inverse of [E | K]; raises NotProved."""
    rows = zip(chart.wide.table(), chart.deep.table(), strict=True)
    return inverse(arb_mat([[*x, *y] for x, y in rows]), "a chart is singular")


def covers(image: Image, source: Rectangle, target: Rectangle, eta: arb, where: str) -> Margins:
    """A covering relation with cones; raises NotProved."""

    def size(row: int, first: int = 0) -> arb:
        return upper(summed(upper(column[row]) for column in image.columns[first:]))

    high = upper(image.shift[1]) + size(1)
    certainly(high < target.height, f"{where}: the image is too high")
    for row in range(2, 6):
        deep = upper(image.shift[row]) + size(row)
        certainly(deep < eta, f"{where}: the image may lie on another sheet of the level")
    rest = arb(0, size(0, 1))
    left, right = (image.shift[0] + side * image.columns[0][0] + rest for side in (-1, 1))
    if left > right:
        left, right = right, left
    certainly(left < target.middle - target.width, f"{where}: the image ends in the set")
    certainly(right > target.middle + target.width, f"{where}: the image ends in the set")
    by, over = (source.width, source.height), (target.width, target.height)
    (a, b), (c, d) = ([image.slope[i, j] * by[j] / over[i] for j in (0, 1)] for i in (0, 1))
    xx, xy, yy = a * a - c * c - 1, a * b - c * d, b * b - d * d + 1
    determinant = xx * yy - xy * xy
    certainly(xx > 0, f"{where}: the cone condition")
    certainly(determinant > 0, f"{where}: the cone condition")
    edges = (target.middle - left).lower(), (right - target.middle).lower()
    stretch = edges[0].min(edges[1]) / target.width
    return Margins(stretch, high / target.height, determinant.lower())


#: What a certificate may claim, and who checks it.
KINDS: dict[str, Callable[[object, Tell | None], list[str]]] = {
    "state": state,
    "orbit": orbit,
    "stability": stability,
    "chaos": chaos,
}


def verify(data: bytes, tell: Tell | None = None) -> list[str]:
    """Check a certificate: what it proves, in lines; raises NotProved, Damaged."""
    certificate = parse(data)
    if not isinstance(certificate, dict) or certificate.get("format") != FORMAT:
        raise Damaged(f"expected the format {FORMAT!r}")
    kind = certificate.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise Damaged(f"kind: expected {' or '.join(KINDS)}")
    before = ctx.prec
    try:
        proved = KINDS[kind](certificate, tell)
    except (ZeroDivisionError, OverflowError):
        raise NotProved("a number is too large, or too small") from None
    finally:
        ctx.prec = before
    scene = ", ".join(f"{key} {_shown(x)}" for key, x in certificate["scene"].items())
    return [f"scene: {scene}", *proved]


def _shown(value: object) -> str:
    """A part of a scene as JSON, with numbers of any size."""
    if isinstance(value, list):
        return f"[{', '.join(map(_shown, value))}]"
    return str(fmpz(value)) if isinstance(value, int) else json.dumps(value)


def main(arguments: Sequence[str]) -> int:
    """Print what is proved: exit code 0; 1 where nothing is, 2 for what is no certificate."""
    if len(arguments) != 1:
        print("usage: python verify.py CERT.json, or - for the standard input", file=sys.stderr)
        return 2
    try:
        print("\n".join(verify(read(arguments[0]), forecast())))
        return 0
    except NotProved as fault:
        print(f"{arguments[0]}: not proved: {fault}")
        return 1
    except Damaged as fault:
        print(f"{arguments[0]}: no certificate: {fault}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


def forecast() -> Tell:
    """Says now and then on stderr how long the rest will take, once it takes 10 seconds."""
    began = said = time.monotonic()

    def tell(part: float, steps: int) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said > 10 and part > 0:
            said, left = now, (now - began) / part * (1 - part)
            print(f"{steps} steps, {100 * part:.0f} %, {left:.0f} s left", file=sys.stderr)

    return tell


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
