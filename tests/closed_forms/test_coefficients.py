"""The families with one orbit per body are theorems: their formulas solve the equations exactly.

A state is a polynomial in z, Y and Z with Y^2 = Q(z), Z^2 = R(z) and z' = k Y Z.  For one body the
six equations and |gamma| = 1 are then equalities of polynomials with rational coefficients, and
the moments enter as quotients of polynomials: what holds at more bodies than their degree holds at
all.  No number is rounded here.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import pytest
from flint import fmpq, fmpq_poly

from polhode.closed_forms._one_orbit import (
    bobylev_steklov,
    chaplygin,
    goryachev,
    grioli,
    n_kowalewski,
    steklov,
)
from polhode.closed_forms._one_orbit.orbits import GammaOfOmega, gamma_of_omega
from polhode.closed_forms.membership import NormalScene

F = Fraction
NOTHING = (F(0),) * 3


def rational(x):
    return fmpq(F(x).numerator, F(x).denominator)


class Flow:
    """The field of z, Y and Z; ``k``, ``Q`` and ``R`` as above."""

    def __init__(self, k, Q, R):
        self.k = rational(k)
        self.squares = [fmpq_poly([rational(x) for x in row]) for row in (Q, R)]
        self.z = Element(self, {0: fmpq_poly([0, 1])})
        self.Y, self.Z = (Element(self, {n: fmpq_poly([1])}) for n in (1, 2))


class Element:
    """Polynomials in z by what they are factors of: 0 of 1, 1 of Y, 2 of Z, 3 of Y Z."""

    def __init__(self, flow, parts):
        self.flow, self.parts = flow, parts

    def _of(self, value):
        if isinstance(value, Element):
            return value
        return Element(self.flow, {0: fmpq_poly([rational(value)])})

    def _with(self, terms):
        total = {}
        for n, x in terms:
            total[n] = total[n] + x if n in total else x
        return Element(self.flow, total)

    def __add__(self, value):
        return self._with((*self.parts.items(), *self._of(value).parts.items()))

    def __mul__(self, value):
        def terms():
            for n, x in self.parts.items():
                for m, y in self._of(value).parts.items():
                    product = x * y
                    for bit, square in enumerate(self.flow.squares):
                        if n & m & 1 << bit:
                            product *= square
                    yield n ^ m, product

        return self._with(terms())

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1

    def __sub__(self, value):
        return self + -self._of(value)

    def __rsub__(self, value):
        return -self + value

    def __truediv__(self, number):
        return self * (1 / F(number))

    @property
    def is_zero(self):
        return all(x == 0 for x in self.parts.values())

    @property
    def rate(self):
        """Its derivative: z' = k Y Z, Y' = k Q' Z/2, Z' = k R' Y/2."""
        flow = self.flow
        slopes = [Element(flow, {0: x.derivative()}) / 2 for x in flow.squares]
        total = self._of(0)
        for n, x in self.parts.items():
            total += Element(flow, {n: x.derivative()}) * flow.Y * flow.Z
            if n & 1:
                total += Element(flow, {n ^ 1: x}) * slopes[0] * flow.Z
            if n & 2:
                total += Element(flow, {n ^ 2: x}) * slopes[1] * flow.Y
        return self._with((n, flow.k * x) for n, x in total.parts.items())


def cross(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def solves(moments, torque, state, square=1):
    """Whether I w' + w x Iw = gamma x T, gamma' = gamma x w, and |gamma|^2 is that number."""
    w, gamma = state[:3], state[3:]
    spun = [a * x for a, x in zip(moments, w, strict=True)]
    gained, lost = cross(gamma, torque), cross(w, spun)
    rests = [a.rate - b + c for a, b, c in zip(spun, gained, lost, strict=True)]
    rests += [a.rate - b for a, b in zip(gamma, cross(gamma, w), strict=True)]
    rests.append(sum((x * x for x in gamma), -F(square)))
    return all(x.is_zero for x in rests)


def of_omega(moments, c, polynomials: GammaOfOmega):
    """The state of q^2 = Q(p), r^2 = R(p), p' = (B - C) q r/A."""
    A, B, C = moments
    flow = Flow((B - C) / A, polynomials.Q, polynomials.R)
    state = flow.z, flow.Y, flow.Z
    return (c, F(0), F(0)), (*state, *polynomials.gamma(*state))


def scene(moments, c):
    return NormalScene(moments, (c, F(0), F(0)), NOTHING, NOTHING)


def steklov_bodies() -> Iterator[bool]:
    """A/C and B/C at 13 x 13 places.

    Over (A - B)(A - C)(A - 2B)(A - 2C)(B - C) a coefficient is of degree 4 at most in each of the
    two, and no term has more than three.  e = -1 is e = 1 with the signs of c and gamma changed.
    """
    for n in range(1, 14):
        for m in range(1, 14):
            B, C, c = 1 + F(n, 3), F(1), F(3, 2)
            A = 2 + (2 * B - 2) * F(m, 15)
            if A == B:
                A += F(1, 97)
            polynomials = steklov.polynomials(scene((A, B, C), c))
            yield solves((A, B, C), *of_omega((A, B, C), c, polynomials))


def goryachev_bodies() -> Iterator[bool]:
    """60 places x = B/C.

    With D = 9x - 8, (x - 2)(3x - 2)(3x - 4) D^4 x makes polynomials of degree 9 at most of the
    coefficients, and no term has more than three of them and four factors x or D.
    """
    for n in range(1, 61):
        B, C, c = 2 + F(2 * n, 3 * 62), F(1), F(5, 2)
        moments = 16 * C * (B - C) / (9 * B - 8 * C), B, C
        yield solves(moments, *of_omega(moments, c, goryachev.polynomials(scene(moments, c))))


def n_kowalewski_bodies() -> Iterator[bool]:
    """60 places x = B/C, for C = c3 = c = 1: |gamma|^2 is then what c3^4 is in general.

    With D = 10x - 9, x^3 D^6 makes polynomials of degree 9 at most of the coefficients, (B - C)/A
    is D/18, and no term has more than three coefficients and four factors x or D.
    """
    for n in range(2, 62):
        B = n + F(1, 7)
        moments = 18 * (B - 1) / (10 * B - 9), B, F(1)
        x = n_kowalewski.coefficients(scene(moments, F(1)))
        polynomials = gamma_of_omega(moments, F(1), x.h, x.Q, x.R)
        yield solves(moments, *of_omega(moments, F(1), polynomials), x.fourth)


def chaplygin_bodies() -> Iterator[bool]:
    """60 places of the body's parameter j, a rational one of the curve of bodies, and B1 = 1.

    B/C is (14 + 6j)/(9 - j^2) and A/B linear: quotients of quadratic polynomials, of which a
    coefficient has four at most and a term three coefficients.
    """
    for n in range(1, 61):
        j, C = 1 + F(n, 500), F(1)
        B = (14 + 6 * j) / (9 - j * j) * C
        A = B * (3 - j) / 3
        x = chaplygin.coefficients(scene((A, B, C), F(1)))
        flow = Flow((B - C) / (3 * A), (1, 0, 0, 0, x.b2), (x.ratio, 0, 0, 0, x.c2))
        numbers = x.b2, x.c2, F(1), x.ratio
        state = chaplygin.state_of((A, B, C), F(1), numbers, flow.z, flow.Y, flow.Z)
        # c = 1 and B1 = 1 leave the length of gamma: c^2 |gamma|^2 = B1^3/cube
        yield solves((A, B, C), (F(1), F(0), F(0)), state, 1 / x.cube)


def bobylev_steklov_bodies() -> Iterator[bool]:
    """B, p, Ga and k at three places each: they enter as quadratic polynomials."""
    for B in map(F, (1, 2, 3)):
        for p in map(F, (0, 1, 2)):
            for Ga in map(F, (0, 1, 2)):
                for k in map(F, (1, 2, 3)):
                    b, e = 2 * (k * Ga - p * p), 4 * k * k * (1 - Ga * Ga)
                    flow = Flow(1, (e / 4, 0, b / 2, 0, F(-1, 4)), (1,))
                    constant = 0 * flow.z + p
                    state = bobylev_steklov.state_of(constant, Ga, k, flow.z, flow.Y * flow.Z)
                    yield solves((F(2), B, F(1)), (k, F(0), F(0)), state)


def grioli_bodies() -> Iterator[bool]:
    """n = 1, e1 of rational slope; z = cos ph, Y Z = sin ph, of P gamma and T = e1."""
    for u in (F(1, 7), F(1, 5), F(2, 5), F(3, 7), F(1, 3), F(2, 9), F(4, 9)):
        t = 2 * u / (1 - u * u)
        size = (1 + u * u) / (1 - u * u)
        for B, C in ((F(2), F(1)), (F(3), F(2)), (F(7, 2), F(3)), (F(5), F(1)), (F(5, 3), F(1))):
            A = B + t * t * (B - C)
            x, z = t / size, 1 / size
            axes = (x, F(0), z), (-z, F(0), x)
            I11, J = A + C - B, (C - A) * x * z
            flow = Flow(-1, (1, 0, -1), (1,))
            w, up = grioli.directions(axes, I11, J, flow.z, flow.Y * flow.Z)
            yield solves((A, B, C), axes[0], (*w, *up), I11 * I11 + J * J)


@pytest.mark.parametrize(
    "bodies",
    [
        *(steklov_bodies, goryachev_bodies, n_kowalewski_bodies, chaplygin_bodies),
        *(bobylev_steklov_bodies, grioli_bodies),
    ],
)
def test_the_formulas_solve_the_equations_at_more_bodies_than_their_degree(bodies):
    assert all(bodies())
