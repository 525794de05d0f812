"""Check a certificate of polhode: python-flint and the standard library, nothing else.

    python verify.py CERT.json

A certificate states balls that hold the state of a heavy rigid body at certain times.  This file
imports nothing of the program that wrote it, and believes nothing of it but the body and the
statement: the grid, the centres and the numbers of bits are guesses that may be anything.

The equations, in body axes, O fixed, omega = w, upward vertical gamma, k = weight * centre:

    I w' = I w x w + gamma x k,    gamma' = gamma x w,        x = (w, gamma),  x' = f(x).

f is quadratic: f(x + z) = f(x) + f'(x) z + B(z, z).  On a step of length h, tau in [0, 1], let p
be any polynomials, A = h f'(p), d = p' - h f(p).  The motion is p + z, where
z' = A z + h B(z, z) - d.  Norms are maxima, of matrices row sums; |B(z, z)| <= beta |z|^2.  With

    alpha >= int |A|,  delta >= int |d|,  eps >= |z(0)|,  e^alpha (eps + delta + |h| beta r^2) < r

|z| < r on the whole step, by Gronwall's lemma and continuity, and for any matrix polynomials V

    z(tau) in V(tau) z(0) + [-s, s]^6,   s = e^alpha (delta + |h| beta r^2) + rho eps,
    rho = e^alpha (|1 - V(0)| + int |A V - V'|),

by variation of constants.  Integrals of a polynomial's norm are bounded by the sums of the norms of
its coefficients k over k + 1, so the bounds hold for every tau.  The set of all z is kept as
m + G xi, m and G exact, xi in a cube; V carries both on, and a change of centre moves m.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TypeVar

from flint import arb, arb_mat, arb_poly, ctx, fmpq

FORMAT = "polhode certificate 1"
LARGEST = 64_000_000  # bytes of a file
MOST_BITS, MOST_STEPS, MOST_DIGITS = 20_000, 1_000_000, 20_000
MOST_WORK = 20_000_000_000  # steps times bits squared
NAMES = ("p", "q", "r", "gamma1", "gamma2", "gamma3")
GROUP = 24  # steps
COARSE = 64  # bits where 2^-46 relatively is enough: matrices and bounds

Interval = tuple[Fraction, Fraction]  # middle and radius
Claim = tuple[Fraction, list[Interval]]  # a time and six balls
X = TypeVar("X", arb, arb_poly)


class NotProved(Exception):
    """The first inequality that does not hold, in words."""


class Damaged(Exception):
    """What of a file is no certificate."""


# -- reading ------------------------------------------------------------------------------------


def read(path: str) -> object:
    """The certificate in a file; raises Damaged."""
    try:
        with open(path, "rb") as file:
            text = file.read(LARGEST + 1)
        if len(text) > LARGEST:
            raise Damaged(f"larger than {LARGEST} bytes")
        return json.loads(
            text, object_pairs_hook=_once, parse_float=_no_float, parse_constant=_no_float
        )
    except OSError as fault:
        raise Damaged(str(fault)) from None
    except (ValueError, RecursionError) as fault:
        raise Damaged(f"no JSON ({fault})") from None


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise Damaged("a key stands twice")
    return found


def _no_float(text: str) -> object:
    raise Damaged(f"{text[:40]}: data are whole numbers or texts, no floats")


def _keys(table: object, names: Sequence[str], where: str) -> list[object]:
    if not isinstance(table, dict) or set(table) != set(names):
        raise Damaged(f"{where}: expected the keys {', '.join(names)}, nothing else")
    return [table[name] for name in names]


def _whole(value: object, low: int, high: int, where: str) -> int:
    if type(value) is not int or not low <= value <= high:
        raise Damaged(f"{where}: expected a whole number from {low} to {high}")
    return value


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
                return Fraction(value)
            except (ValueError, ZeroDivisionError):
                pass
    raise Damaged(f"{where}: expected a whole number, or a text with a decimal or a fraction")


def _interval(value: object, where: str) -> Interval:
    """Middle and radius: of one number, or of two in a list."""
    if isinstance(value, list):
        middle, radius = (_rational(x, where) for x in _list(value, 2, where))
        if radius < 0:
            raise Damaged(f"{where}: expected a radius that is not negative")
        return middle, radius
    return _rational(value, where), Fraction(0)


def ball(interval: Interval) -> arb:
    """Middle and radius, rationals, as a ball at the present precision."""
    middle, radius = (arb(fmpq(x.numerator, x.denominator)) for x in interval)
    return middle + arb(0, upper(radius)) if interval[1] else middle


def dyadic(number: int, power: int) -> arb:
    """number 2^power, exact."""
    found = arb(number) * arb(2) ** power
    certainly(found.is_exact(), "a number is longer than its bits")
    return found


# -- balls --------------------------------------------------------------------------------------


def upper(x: arb) -> arb:
    """A number that no value of a ball exceeds in modulus, exact."""
    return x.abs_upper()


def certainly(true: object, line: str) -> None:
    """Refuse unless a comparison of balls is certain; one with nan is not."""
    if true is not True:
        raise NotProved(line)


def largest(numbers: Iterable[arb]) -> arb:
    """An upper bound of the moduli of several numbers."""
    found = arb(0)
    for x in numbers:
        found = found.max(upper(x))
    return found


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
    """f as tables of coefficients, balls; what is exactly zero stands nowhere."""

    def __init__(self, inertia: Sequence[Sequence[arb]], torque: Sequence[arb]) -> None:
        self.quadratic: dict[
            tuple[int, ...], arb
        ] = {}  # (row, a, b): the coefficient of w_a w_b, a <= b
        self.linear: dict[tuple[int, ...], arb] = {}  # (row, j): of gamma_j
        for i, n, weight in _inverse(inertia):
            a, b = (n + 1) % 3, (n + 2) % 3
            for j in range(3):  # (I w x w)_n = (I w)_a w_b - (I w)_b w_a
                self._add(self.quadratic, (i, min(j, b), max(j, b)), weight * inertia[a][j])
                self._add(self.quadratic, (i, min(j, a), max(j, a)), -weight * inertia[b][j])
            self._add(self.linear, (i, a), weight * torque[b])  # (gamma x k)_n
            self._add(self.linear, (i, b), -weight * torque[a])
        sizes = [
            summed(upper(x) for (row, *_), x in self.quadratic.items() if row == i)
            for i in range(3)
        ]
        self.beta = largest([*sizes, arb(2)])

    @staticmethod
    def _add(table: dict[tuple[int, ...], arb], key: tuple[int, ...], x: arb) -> None:
        found = table.pop(key, arb(0)) + x
        if not (found.is_exact() and found == 0):
            table[key] = found

    def field(self, x: Sequence[X], product: Callable[[int, int], X]) -> list[X]:
        """The six rates: ``x`` its six values, ``product(i, j)`` that of two of them."""
        found = []
        for i in range(3):
            terms = [product(a, b) * k for (row, a, b), k in self.quadratic.items() if row == i]
            terms += [x[3 + j] * k for (row, j), k in self.linear.items() if row == i]
            found.append(sum(terms, x[i] * arb(0)))
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            found.append(product(3 + a, b) - product(3 + b, a))
        return found

    def derivative(self, x: Sequence[arb_poly]) -> dict[tuple[int, int], arb_poly]:
        """The entries of f'(x) that are not zero, by row and column; x polynomials."""
        found: dict[tuple[int, int], arb_poly] = {}

        def add(i: int, j: int, term: arb_poly) -> None:
            found[i, j] = found[i, j] + term if (i, j) in found else term

        for (i, a, b), k in self.quadratic.items():
            add(i, a, x[b] * k)
            add(i, b, x[a] * k)
        for (i, j), k in self.linear.items():
            add(i, 3 + j, arb_poly([k]))
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            add(3 + i, 3 + a, x[b])
            add(3 + i, b, x[3 + a])
            add(3 + i, 3 + b, -x[a])
            add(3 + i, a, -x[3 + b])
        return found


def _inverse(inertia: Sequence[Sequence[arb]]) -> list[tuple[int, int, arb]]:
    """The entries of the inverse matrix, by row and column; a diagonal one's is as sharp as it."""
    if all(inertia[i][j] == 0 for i in range(3) for j in range(3) if i != j):
        return [(i, i, 1 / inertia[i][i]) for i in range(3)]
    found = arb_mat(inertia).inv()
    return [(i, n, found[i, n]) for i in range(3) for n in range(3)]


# -- guesses, which nothing rests on ------------------------------------------------------------


def taylor(body: Body, centre: Sequence[arb], h: arb, bits: int) -> list[list[arb]]:
    """Exact coefficients of polynomials near the motion that begins at a centre."""
    rows, least, small = [[x.mid()] for x in centre], arb(2) ** -bits, 0
    for k in range(bits + 20):
        rates = body.field(
            [row[k] for row in rows],
            lambda i, j: summed(x * y for x, y in zip(rows[i], reversed(rows[j]), strict=True)),
        )
        for row, rate in zip(rows, rates, strict=True):
            row.append((rate * h / (k + 1)).mid())
        small = small + 1 if largest(row[-1] for row in rows) < least else 0
        if small == 2:
            break
    return rows


def transition(a: Sequence[arb_mat]) -> list[arb_mat]:
    """Exact matrices near the coefficients of V' = A V, V(0) = 1."""
    v, small = [arb_mat([[int(i == j) for j in range(6)] for i in range(6)])], 0
    for k in range(80):
        total = arb_mat(6, 6)
        for j in range(min(k + 1, len(a))):
            total += a[j] * v[k - j]
        v.append((total / arb(k + 1)).mid())
        small = small + 1 if row_sum(v[-1].table()) < arb(2) ** -50 else 0
        if small == 2:
            break
    return v


# -- one step, and the set ----------------------------------------------------------------------


class Step:
    """Polynomials p and V about a centre, and those bounds of the theorem that need no set."""

    def __init__(self, body: Body, centre: Sequence[arb], h: arb, bits: int) -> None:
        ctx.prec = bits
        self.bits = bits
        self.p = [arb_poly(row) for row in taylor(body, centre, h, bits)]
        rates = body.field(self.p, lambda i, j: self.p[i] * self.p[j])
        defect = [
            (row.derivative() - rate * h).coeffs() for row, rate in zip(self.p, rates, strict=True)
        ]
        ctx.prec = COARSE
        self.delta = integral(
            [largest(_entry(row, k) for row in defect) for k in range(max(map(len, defect)))]
        )
        entries = {place: (x * h).coeffs() for place, x in body.derivative(self.p).items()}
        a = []
        for k in range(max(map(len, entries.values()))):
            a.append(arb_mat(6, 6))
            for (i, j), x in entries.items():
                a[k][i, j] = _entry(x, k)
        norms = [row_sum(x.table()) for x in a]
        self.growth = upper(integral(norms).exp())
        self.beta = upper(h) * body.beta
        self.v = transition(a)
        self.rho = self.growth * self._residual(a, norms)

    def _residual(self, a: Sequence[arb_mat], norms: Sequence[arb]) -> arb:
        """An upper bound of the integral of |A V - V'|; V(0) is the unit matrix exactly."""
        last = len(self.v) - 1
        sizes, found = [row_sum(x.table()) for x in self.v], []
        for k in range(last):
            total = self.v[k + 1] * arb(-(k + 1))
            for j in range(min(k + 1, len(a))):
                total += a[j] * self.v[k - j]
            found.append(row_sum(total.table()))
        rest = summed(
            one * other / (j + k + 1)
            for j, one in enumerate(norms)
            for k, other in enumerate(sizes)
            if j + k >= last
        )
        return integral(found) + upper(rest)

    def noise(self, eps: arb) -> arb:
        """s for all |z(0)| <= eps; raises NotProved where the theorem's condition fails."""
        r = upper(2 * self.growth * (eps + self.delta)) + arb(2) ** -100_000
        claimed = self.growth * (eps + self.delta + self.beta * r * r)
        certainly(claimed < r, "the condition of the step")
        return upper(self.growth * (self.delta + self.beta * r * r) + self.rho * eps)

    def at(self, tau: arb) -> tuple[list[arb], arb_mat]:
        """p and V at a moment of the step, a number from 0 to 1."""
        ctx.prec = self.bits
        middle = [row(tau) for row in self.p]
        ctx.prec = COARSE
        found = self.v[-1]
        for one in self.v[-2::-1]:
            found = found * tau + one
        return middle, found


def _entry(coefficients: Sequence[arb], k: int) -> arb:
    return coefficients[k] if k < len(coefficients) else arb(0)


class Set:
    """All z = m + G xi, |xi_j| <= 1: rows of G, of which the columns of the last steps stand apart.

    Each step adds six columns, its noise; after a group of steps those of the group become six, the
    smallest box around them.
    """

    def __init__(self, m: Sequence[arb], box: Sequence[arb]) -> None:
        self.m = m
        self.old = _diagonal(box)
        self.young: list[list[arb]] = [[] for _ in range(6)]

    @property
    def size(self) -> arb:
        """An upper bound of |z|."""
        return largest(upper(x) + y for x, y in zip(self.m, self.spread(), strict=True))

    def spread(self) -> list[arb]:
        """Upper bounds of |G xi|, entry by entry."""
        rows = zip(self.old, self.young, strict=True)
        return [summed(upper(x) for x in (*old, *young)) for old, young in rows]

    def carried(self, v: arb_mat, s: arb) -> tuple[list[arb], list[list[arb]], list[arb]]:
        """Where a step takes it: m as balls, G as exact numbers, and bounds of what is left out."""
        moved = [row[0] for row in (v * arb_mat([[x] for x in self.m])).table()]
        g = [[*old, *young] for old, young in zip(self.old, self.young, strict=True)]
        rows = (v * arb_mat(g)).table()
        noise = [upper(s + summed(x.rad() for x in row)) for row in rows]
        return moved, [[x.mid() for x in row] for row in rows], noise

    def within(self, step: Step, s: arb, tau: Fraction) -> list[arb]:
        """The motion's state at a moment of a step that begins here, as balls."""
        ctx.prec = step.bits
        middle, v = step.at(ball((tau, Fraction(0))))
        moved, rows, noise = self.carried(v, s)
        around = [upper(summed(map(upper, row)) + x) for row, x in zip(rows, noise, strict=True)]
        ctx.prec = step.bits
        return [x + y + arb(0, z) for x, y, z in zip(middle, moved, around, strict=True)]

    def next(self, step: Step, s: arb, centre: Sequence[arb]) -> Set:
        """The set about the next centre."""
        middle, v = step.at(arb(1))
        moved, rows, noise = self.carried(v, s)
        ctx.prec = step.bits
        jump = [middle[i] + moved[i] - centre[i] for i in range(6)]
        ctx.prec = COARSE
        found = Set([x.mid() for x in jump], [])
        new = _diagonal([upper(x.rad() + y) for x, y in zip(jump, noise, strict=True)])
        first = len(self.old[0])
        found.old = [row[:first] for row in rows]
        found.young = [row[first:] + more for row, more in zip(rows, new, strict=True)]
        if len(found.young[0]) >= 6 * GROUP:
            box = _diagonal([upper(summed(map(upper, row))) for row in found.young])
            found.old = [row + more for row, more in zip(found.old, box, strict=True)]
            found.young = [[] for _ in range(6)]
        return found


def _diagonal(box: Sequence[arb]) -> list[list[arb]]:
    return [[x if i == j else arb(0) for j, x in enumerate(box)] for i in range(6)]


# -- the claim ----------------------------------------------------------------------------------


def state(certificate: object) -> list[Claim]:
    """Check the statement of a certificate of states; raises NotProved, Damaged."""
    names = (
        *("format", "kind", "scene", "time_bits", "grid", "state_bits", "centres", "bits"),
        "statement",
    )
    held = dict(zip(names, _keys(certificate, names, "the certificate"), strict=True))
    bits = _whole(held["bits"], COARSE, MOST_BITS, "bits")
    time_bits = _whole(held["time_bits"], -MOST_BITS, MOST_BITS, "time_bits")
    state_bits = _whole(held["state_bits"], -MOST_BITS, MOST_BITS, "state_bits")
    grid = _grid(held["grid"])
    guesses = [
        [_whole(x, -(2**MOST_BITS), 2**MOST_BITS, "centres") for x in _list(row, 6, "centres")]
        for row in _list(held["centres"], len(grid) - 1, "centres")
    ]
    claims = _claims(held["statement"])
    sense, unit = (1 if grid[-1] > 0 else -1), Fraction(2) ** -time_bits
    for t, _ in claims:
        if not 0 <= sense * t <= sense * grid[-1] * unit:
            raise NotProved(f"t = {written(t)} lies outside the grid")
    ctx.prec = bits + 2 * COARSE
    scene = read_scene(held["scene"])
    _check_start(claims, scene[2])
    if len(grid) * bits**2 > MOST_WORK:
        raise Damaged(f"{len(grid)} steps at {bits} bits are too many")
    try:
        moments, torque, start = balls_of(scene)
        shift = scaling(moments, torque, start)
        body = Body(moments, [x * arb(2) ** (-2 * shift) for x in torque])
    except (ZeroDivisionError, OverflowError, ValueError):
        raise NotProved("the body's moments of inertia have no inverse") from None
    rates = [*[arb(2) ** -shift] * 3, *[arb(1)] * 3]
    start = [x * rate for x, rate in zip(start, rates, strict=True)]
    powers = [-state_bits - shift] * 3 + [-state_bits] * 3
    centres = [[dyadic(x, e) for x, e in zip(row, powers, strict=True)] for row in guesses]
    offset = [x - y for x, y in zip(start, centres[0], strict=True)]
    found = Set([x.mid() for x in offset], [upper(x.rad()) for x in offset])
    for n, (first, last) in enumerate(pairwise(grid)):
        try:
            step = Step(body, centres[n], dyadic(last - first, shift - time_bits), bits)
            s = step.noise(found.size)
            for claim in claims:
                tau = (claim[0] / unit - first) / (last - first)
                if 0 < tau <= 1:
                    _check(claim, found.within(step, s, tau), rates)
            if n + 1 < len(centres):
                found = found.next(step, s, centres[n + 1])
        except (ZeroDivisionError, OverflowError):
            raise NotProved(f"step {n + 1}: a number is too large") from None
        except NotProved as fault:
            raise NotProved(f"step {n + 1} of {len(centres)}: {fault}") from None
    return claims


def _grid(value: object) -> list[int]:
    grid = [_whole(x, -(2**62), 2**62, "grid") for x in _list(value, None, "grid")]
    if not 2 <= len(grid) <= MOST_STEPS or grid[0] != 0:
        raise Damaged(f"grid: expected 0 and up to {MOST_STEPS} times after it")
    sense = 1 if grid[1] > 0 else -1
    if any(sense * (b - a) <= 0 for a, b in pairwise(grid)):
        raise Damaged("grid: expected times in order away from 0")
    return grid


Scene = tuple[list[list[Interval]], list[list[Interval]], list[Interval]]


def read_scene(scene: object) -> Scene:
    """Inertia, centre and weight, and start of a scene; raises Damaged."""
    diagonal = isinstance(scene, dict) and "moments" in scene
    names = ("moments" if diagonal else "inertia", "centre", "weight", "omega", "gamma")
    form, centre, weight, omega, gamma = _keys(scene, names, "scene")
    none = (Fraction(0), Fraction(0))
    if diagonal:
        moments = _vector(form, "moments")
        rows = [[moments[i] if i == j else none for j in range(3)] for i in range(3)]
    else:
        rows = [_vector(row, "inertia") for row in _list(form, 3, "inertia")]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise Damaged("inertia: expected a symmetric matrix")
    held = [_vector(centre, "centre"), [_interval(weight, "weight")]]
    return rows, held, _vector(omega, "omega") + _vector(gamma, "gamma")


def _vector(value: object, where: str) -> list[Interval]:
    return [_interval(x, where) for x in _list(value, 3, where)]


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
    found: list[Claim] = []
    for row in _list(statement, None, "statement"):
        t, balls = _keys(row, ("t", "balls"), "statement")
        pairs = [_interval(_list(x, 2, "balls"), "balls") for x in _list(balls, 6, "balls")]
        found.append((_rational(t, "t"), pairs))
    if not found:
        raise Damaged("statement: expected at least one time")
    return found


def _check_start(claims: Sequence[Claim], start: Sequence[Interval]) -> None:
    for t, balls in claims:
        for name, (x, r), (middle, radius) in zip(NAMES, start, balls, strict=True):
            if t == 0 and abs(x - middle) + r > radius:
                raise NotProved(f"{name} at t = 0 is not in its ball")


def _check(claim: Claim, there: Sequence[arb], rates: Sequence[arb]) -> None:
    t, balls = claim
    for name, x, rate, pair in zip(NAMES, there, rates, balls, strict=True):
        middle, radius = (arb(fmpq(y.numerator, y.denominator)) for y in pair)
        line = f"{name} at t = {written(t)} is not shown to lie in its ball"
        certainly(abs(x / rate - middle) <= radius, line)


def written(t: Fraction) -> str:
    """A time in full where that is short, else what it is about."""
    found = str(t) if abs(t.numerator) < 10**20 and t.denominator < 10**20 else ""
    return found or f"about {decimal(abs(t), up=False, minus=t < 0)}"


def rounded_up(x: Fraction) -> str:
    """A bound with two digits, not below the number."""
    return decimal(x, up=True, minus=False) if x else "0"


def decimal(x: Fraction, up: bool, minus: bool) -> str:
    """Two digits and an exponent, of any size."""
    power = math.floor((x.numerator.bit_length() - x.denominator.bit_length()) * math.log10(2)) - 1
    scaled = x / Fraction(10) ** power
    while scaled >= 100:
        scaled, power = scaled / 10, power + 1
    digits = math.ceil(scaled) if up else math.floor(scaled)
    if digits >= 100:
        digits, power = 10, power + 1
    return f"{'-' * minus}{digits // 10}.{digits % 10}e{power + 1:+03d}"


#: What a certificate may claim, and who checks it.
KINDS = {"state": state}


def verify(path: str) -> list[str]:
    """Check the certificate in a file: what it proves, in lines; raises NotProved, Damaged."""
    certificate = read(path)
    if not isinstance(certificate, dict) or certificate.get("format") != FORMAT:
        raise Damaged(f"expected the format {FORMAT!r}")
    kind = certificate.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise Damaged(f"kind: expected {' or '.join(KINDS)}")
    before = ctx.prec
    try:
        claims = KINDS[kind](certificate)
    finally:
        ctx.prec = before
    scene = ", ".join(f"{key} {json.dumps(x)}" for key, x in certificate["scene"].items())
    last = written(max((t for t, _ in claims), key=abs))
    widest = max(radius for _, balls in claims for _, radius in balls)
    return [
        f"scene: {scene}",
        f"proved: at {len(claims)} times up to t = {last} the motion of this scene "
        f"lies in the balls that the certificate states, of radius {rounded_up(widest)} at most",
    ]


def main(arguments: Sequence[str]) -> int:
    """Print what is proved: exit code 0; 1 where nothing is, 2 for what is no certificate."""
    if len(arguments) != 1:
        print("usage: python verify.py CERT.json", file=sys.stderr)
        return 2
    try:
        print("\n".join(verify(arguments[0])))
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


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
