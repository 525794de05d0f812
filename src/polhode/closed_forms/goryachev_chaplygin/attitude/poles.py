"""Where on the torus of two frequencies a given axis of the body is vertical.

There gamma = s e, s = 1 or -1, e that axis.  As f = 0 and H is known, the angular momentum
(4p, 4q, r) lies on an ellipse at right angles to e,

    (4p, 4q, r) = sqrt(H - 2a s e1) (2 cos nu m1 + sin nu m2/sqrt(e3^2/4 + ro^2)),
    m1 = (-e2, e1, 0)/ro,   m2 = (-e1 e3, -e2 e3, ro^2)/ro,   ro^2 = e1^2 + e2^2,

and G = r(p^2 + q^2) - a p gamma3 is an equation of degree 6 in exp(i nu).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Oscillating
from polhode.closed_forms.goryachev_chaplygin.motion import Separated, state
from polhode.closed_forms.goryachev_chaplygin.separation_variables import started
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

#: al and bt of the attitude at the phases (x, y).
Parameters = Callable[[Scalar, Scalar], tuple[Scalar, Scalar]]


@dataclass(frozen=True)
class Pole:
    """A simple zero of al or bt: its phases, and how often the argument grows by 2 pi around it."""

    x: Any
    y: Any
    charge: int


def poles(
    path: Separated,
    sg: int,
    constants: tuple[Scalar, Scalar],
    axis: Sequence[Scalar],
    of: Parameters,
) -> tuple[list[Pole], list[Pole]]:
    """The zeros of al and of bt, phases in [-pi, 3 pi), at the precision in force.

    ``constants`` are H and G, ``axis`` is e in the motion's axes.  Raises ArithmeticError where two
    of them are too near each other.
    """
    found: tuple[list[Pole], list[Pole]] = ([], [])
    turn, small = 2 * mpmath.pi, mpmath.ldexp(1, -mpmath.prec // 4)
    for which, w, gamma in _upright(path.a, constants, axis):
        place = _phases(path, w, gamma)
        if place is None:
            continue
        # A turn of a phase may change the signs of p, q and gamma3, or only the attitude's.
        places = itertools.product(*((z, z + turn) for z in place))
        zeros = [at for at in places if _off(path, sg, at, (*w, *gamma)) < small]
        found[which].extend(Pole(x, y, _charge(of, which, x, y)) for x, y in zeros)
        if len(zeros) != 2:
            raise ArithmeticError("a place where the axis is vertical was not found")
    if any(sum(pole.charge for pole in row) for row in found):
        raise ArithmeticError("the turns around the places where the axis is vertical do not add")
    return found


def _upright(
    a: Any, constants: tuple[Any, Any], axis: Sequence[Any]
) -> Iterator[tuple[int, Sequence[Any], Sequence[Any]]]:
    """All p, q, r and gamma with the given H, G, f = 0 and gamma along the axis.

    Before each, which parameter is 0 there: al (0, gamma against the axis) or bt (1).
    """
    H, G = constants
    e1, e2, e3 = axis
    ro = mpmath.hypot(e1, e2)
    m1 = (-e2 / ro, e1 / ro, mpf(0)) if ro else (mpf(1), mpf(0), mpf(0))
    m2 = (-e1 * e3 / ro, -e2 * e3 / ro, ro) if ro else (mpf(0), mpf(1), mpf(0))
    for which, s in enumerate((-1, 1)):
        left = H - 2 * a * s * e1
        if left <= 0:
            continue
        one = 2 * mpmath.sqrt(left)
        other = mpmath.sqrt(left / (e3 * e3 / 4 + ro * ro))

        def omega(
            nu: Scalar, one: Scalar = one, other: Scalar = other
        ) -> tuple[Scalar, Scalar, Scalar]:
            c, d = mpmath.cos_sin(nu)
            p, q, r = (one * c * x + other * d * y for x, y in zip(m1, m2, strict=True))
            return p / 4, q / 4, r

        def excess(nu: Scalar, s: int = s, omega: Any = omega) -> Scalar:
            p, q, r = omega(nu)
            return r * (p * p + q * q) - a * p * s * e3 - G

        for nu in _zeros(excess):
            yield which, omega(nu), [s * x for x in (e1, e2, e3)]


def _zeros(function: Callable[[Scalar], Scalar]) -> list[Any]:
    """The zeros of a real trigonometric polynomial of degree 3; double ones are left out."""
    nodes = [mpf(j) / 4 for j in range(8)]
    values = [function(mpmath.pi * x) for x in nodes]
    rows = [
        sum(v * mpmath.expjpi(-k * x) for v, x in zip(values, nodes, strict=True)) / 8
        for k in range(4)
    ]
    size = max(abs(x) for x in rows)
    degree = max(k for k, x in enumerate(rows) if abs(x) > mpmath.ldexp(size, -mpmath.prec // 2))
    if degree == 0:
        return []
    # c_k z^k + ... + c_0 + ... + conj(c_k) z^-k, times z^k
    terms = [rows[abs(k)] if k >= 0 else mpmath.conj(rows[-k]) for k in range(-degree, degree + 1)]
    try:
        roots = mpmath.polyroots(terms, maxsteps=200, extraprec=mpmath.prec, asc=True)
    except mpmath.NoConvergence as error:
        raise ArithmeticError("two places where the axis is vertical are near") from error
    near = mpmath.ldexp(1, -2 * mpmath.prec // 5)
    found: list[Any] = []
    for z in roots:
        if abs(abs(z) - 1) > near:
            continue
        # Of a double zero the turns cancel.
        other = next((w for w in found if abs(w - z) < 4 * near), None)
        if other is None:
            found.append(z)
        else:
            found.remove(other)
    return [mpmath.arg(mpc(z)) for z in found]


def _phases(path: Separated, w: Sequence[Any], gamma: Sequence[Any]) -> tuple[Any, Any] | None:
    """The phases x and y, each but for whole turns; None on another torus of the same H and G."""
    (p, q, r), (_, g2, g3) = w, gamma
    flat = 4 * (p * p + q * q)
    larger = (abs(r) + mpmath.sqrt(r * r + 4 * flat)) / 2
    u, v = (larger, flat / larger) if r >= 0 else (flat / larger, larger)
    found = []
    for clock, z, sine in (
        (path.torus.u, u, 2 * q * g3 / u - g2),
        (path.torus.v, v, 2 * q * g3 / v + g2),
    ):
        assert isinstance(clock, Oscillating)
        variable = clock.variable
        gap = (variable.high - variable.low) * mpmath.ldexp(1, -mpmath.prec // 3)
        if not variable.low - gap < z < variable.high + gap:
            return None
        z = min(max(z, variable.low), variable.high)
        found.append(clock.chart.inverse(started(variable, z, sine, path.a)))
    return found[0], found[1]


def _off(path: Separated, sg: int, place: tuple[Any, Any], wanted: Sequence[Any]) -> Any:
    """How far the state at the phases is from w and gamma."""
    point = path.joined(path.torus.u.at(place[0], MP), path.torus.v.at(place[1], MP), MP)
    return max(abs(x - y) for x, y in zip(state(point, sg), wanted, strict=True))


def _charge(of: Parameters, which: int, x: Any, y: Any) -> int:
    """The sign of the determinant of the derivatives by x and y."""
    step = mpmath.ldexp(1, -mpmath.prec // 3)
    middle = of(x, y)[which]
    one, other = of(x + step, y)[which] - middle, of(x, y + step)[which] - middle
    across = mpmath.im(mpmath.conj(one) * other)
    if abs(across) < mpmath.ldexp(abs(one) * abs(other), -mpmath.prec // 6):
        raise ArithmeticError("two places where the axis is vertical are near each other")
    return 1 if across > 0 else -1
