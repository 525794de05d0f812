"""Bobylev and Steklov's motions in closed form: A = 2C, any B, the centre of mass on axis 1.

With T = Mg r0 = (x, 0, 0) and k = x/C, a start with q = 0 and k gamma3 = p r keeps both; p and
Ga = gamma1 + r^2/2k are constant, and

    gamma1 = Ga - r^2/2k,    gamma2 = -r'/k,    gamma3 = p r/k,
    4 r'^2 = (R1 - r^2)(r^2 - R2),    R1 + R2 = 2b,  R1 R2 = -e,
    b = 2 (k Ga - p^2),  e = 4 k^2 (1 - Ga^2)

(D. K. Bobylev 1896 and V. A. Steklov 1896 for A = 2C; the moment B does not enter).  With
v = v0 + nu t

    Ga^2 < 1:   r = sqrt(R1) cn v,        m = R1/(R1 - R2),    nu = sqrt(R1 - R2)/2;
    Ga^2 >= 1:  r = +-sqrt(R1) dn v,      m = (R1 - R2)/R1,    nu = sqrt(R1)/2;

Ga = 1 is asymptotic to the rotation p about the upright axis 1: r = +-sqrt(R1) sech v
(:class:`Asymptotic`).  The axes are taken so that x > 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.family import Family, orbit_family
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    moving,
    on_axis_1,
)
from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._one_orbit.orbits import EllipticOrbit
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms._winding.winding_number import bisected
from polhode.closed_forms.functions.elliptic import elliptic
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import ZERO, sign, sqrt
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar


def conditions(scene: Placed) -> Iterator[Condition]:
    """A = 2C, the centre on axis 1, q = 0 and x0 gamma3 Mg = C p r; not a rotation."""
    A, _, C = scene.moments
    p, q, r = scene.omega
    yield equal("A = 2C", A, 2 * C)
    yield from on_axis_1(scene)
    yield equal("q = 0", q, 0, scene.speed)
    k = scene.torque[0] / C
    yield equal("Mg x0 gamma3 = C p r", k * scene.gamma[2], p * r, k)
    yield moving(scene)


@dataclass(frozen=True)
class Asymptotic:
    """The quaternion body -> space as a function of time, at one precision.

    ``placed`` takes an axial vector from the normal axes to the scene's.
    """

    start: Quaternion
    placed: Callable[[Scalar], list[Scalar]]
    determinant: int
    p: Scalar
    nu: Scalar
    v0: Scalar
    positive: bool  # s = 1

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        return self._seen(self.v0 + self.nu * t, self.p * t / 2) if t else self.start

    def _seen(self, v: Scalar, turned: Scalar) -> Quaternion:
        """The attitude at v, with ``turned`` in place of p t/2."""
        w, x, y, z = self._place(self.v0, mpf(0))
        c, *axis = product((w, -x, -y, -z), self._place(v, turned))
        second, third, first = axis
        x, y, z = self.placed((first, second, third))
        return product(self.start, (c, x, y, z))

    def _place(self, v: Scalar, turned: Scalar) -> Quaternion:
        root = mpmath.sqrt(self.p**2 + self.nu**2)
        phase = mpmath.expj(turned) / root
        al = mpc(self.p, self.nu * mpmath.tanh(v)) * phase
        bt = self.nu * mpmath.sech(v) * phase
        if not self.positive:
            bt = -bt
        return al.real, bt.real, bt.imag, al.imag

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t.

        Without their common turn about the vertical the two parameters move at most at sqrt(2) in
        x = atan(sinh v), dx = sech v dv; from |v| = ``last`` on their directions stay.
        """
        last = mpmath.prec * mpmath.ln2 / 3

        def moved(v: Scalar) -> Scalar:
            return 3 * mpmath.atan(mpmath.sinh(min(max(v, -last), last)))

        def fine(x: Scalar) -> tuple[Scalar, Scalar]:
            q0, q1, q2, q3 = self._seen(mpmath.asinh(mpmath.tan(x / 3)), mpf(0))
            return mpc(q0, q3), mpc(q1, q2)

        turned = self.determinant * self.p * t / 2
        one, other = bisected(fine, moved(self.v0), moved(self.v0 + self.nu * t))
        return turned + one, turned + other

    @property
    def speed(self) -> Any:
        """An upper bound of |w|."""
        return abs(self.p) + 2 * self.nu


SWINGING = "Bobylev-Steklov, r changes its sign"
TURNING = "Bobylev-Steklov, r keeps its sign"
ASYMPTOTIC = "Bobylev-Steklov, asymptotic to a rotation about the vertical"


class BobylevSteklov(OrbitMotion):
    """One motion of Bobylev and Steklov."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return (ASYMPTOTIC, SWINGING, TURNING)[self._exact["side"]]

    @cached_property
    def _exact(self) -> dict[str, Any]:
        """The constants, each without cancellation; "side" is the sign of 1 - Ga^2."""
        scene = self.normal
        k = scene.torque[0] / scene.moments[2]
        p, _, r = scene.omega
        Ga = scene.gamma[0] + r * r / (2 * k)
        b, e = 2 * (k * Ga - p * p), 4 * k * k * (1 - Ga * Ga)
        side, root = sign(e), sqrt(b * b + e)
        R1 = b + root if sign(b) > 0 else e / (root - b)
        R2 = -e / R1 if side else ZERO
        found = {"side": side, "k": k, "p": p, "Ga": Ga, "R1": R1}
        up = sign(scene.gamma[1]) or 1
        if side > 0:
            cn2 = r * r / R1
            found |= {"m": R1 / (2 * root), "m1": -R2 / (2 * root), "nu2": root / 2}
            found |= {"sn2": 1 - cn2, "cn2": cn2, "sn": up, "cn": sign(r), "scale": 1}
            return found | {"dn2": found["m1"] + found["m"] * cn2}
        found |= {"m": 2 * root / R1, "m1": R2 / R1, "nu2": R1 / 4, "dn2": r * r / R1}
        found |= {"sn2": (R1 - r * r) / (2 * root), "cn2": (r * r - R2) / (2 * root)}
        return found | {"sn": up * sign(r), "cn": 1, "scale": sign(r)}

    def _orbit(self, bits: int) -> Orbit:
        x = {name: number(value, bits) for name, value in self._exact.items()}
        sn, cn = (x[name] * mpmath.sqrt(x[name + "2"]) for name in ("sn", "cn"))
        functions = elliptic(x["m"], x["m1"])
        swinging, nu = x["side"] > 0, mpmath.sqrt(x["nu2"])
        scale = x["scale"] * mpmath.sqrt(x["R1"])
        k, p, Ga, m = (x[name] for name in ("k", "p", "Ga", "m"))

        def state(sn: Scalar, cn: Scalar, dn: Scalar) -> tuple[Scalar, ...]:
            if swinging:
                r, slope = scale * cn, -scale * nu * sn * dn
            else:
                r, slope = scale * dn, -scale * nu * m * sn * cn
            return p, 0 * r, r, Ga - r * r / (2 * k), -slope / k, p * r / k

        phase = functions.phase(sn, cn, mpmath.sqrt(x["dn2"]))
        return EllipticOrbit(functions, phase, nu, state, 4 if swinging else 2)

    def _turned(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
        motion = self._made(bits)
        assert isinstance(motion, EllipticOrbit)
        if motion.period is not None:
            return super()._turned(start, rate, bits)
        rows = self._scene_axes(bits)

        def placed(v: tuple[Scalar, Scalar, Scalar]) -> list[Scalar]:
            return rows.scene(self._axes.axial_back(v))

        p, positive = number(self._exact["p"], bits), self._exact["scale"] > 0
        return Asymptotic(start, placed, self._axes.determinant, p, motion.nu, motion.v0, positive)


FAMILY: Family = orbit_family("bobylev-steklov", BobylevSteklov)
