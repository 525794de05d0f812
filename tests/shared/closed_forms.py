"""Motions of all families of closed forms, and the same motions by power series.

A motion is a scene: of the library, of ``tests/data/motions.toml``, or of :mod:`shared.members`.
Its reference is asked as users ask it.
"""

import contextlib
import functools
import io
import json
import math
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
from flint import arb
from mpmath import mpf

import polhode
from polhode.cli import main
from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import MotionAxes, conjugate
from polhode.closed_forms.families import FAMILIES, closed_form, form_of
from polhode.closed_forms.membership import PrincipalScene
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import ordinary
from polhode.numbers.vectors import quaternion_product
from shared import fast_series, members

F = Fraction
PSI = F(7, 10)
IDENTITY = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
EVEN = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def number(x: Any) -> mpf:
    """An exact number as mpf, at the precision in force."""
    return mpf(exact.rounded(exact.exact(x), mpmath.mp.prec))


@dataclass(frozen=True, eq=False)
class Motion:
    """``start``: moments, Mg r0, omega, gamma in principal axes; None for a case of the library."""

    family: str
    name: str
    regime: str = ""
    start: tuple[Any, ...] | None = None

    def __str__(self) -> str:
        return self.name if self.start is None else f"{self.family}: {self.name}"

    @functools.cached_property
    def scene(self) -> polhode.Scene:
        """As it is given to polhode."""
        return polhode.load(self.name) if self.start is None else scene_of(self.start, self.family)

    @functools.cached_property
    def reference(self) -> Any:
        """One for all tests that ask it: its constants are made once."""
        return polhode.reference(self.scene)

    @functools.cached_property
    def principal(self) -> tuple[Any, ...] | None:
        """The start in principal axes, where these are the scene's."""
        if self.start is not None:
            return self.start
        scene = self.scene
        if not scene.body.axes.trivial:
            return None
        return scene.body.moments, scene.body.torque, scene.omega, scene.gamma

    @functools.cached_property
    def rate(self) -> Fraction:
        """A power of two near the largest of |w| and sqrt(Mg |r0|/A), A the largest moment."""
        body = self.scene.body
        pull = max(float(abs(x)) for x in body.torque) / float(max(body.moments))
        fastest = max([*(float(abs(x)) for x in self.scene.omega), math.sqrt(pull)])
        return F(2) ** round(math.log2(fastest)) if fastest else F(1)

    def times(self, *turns: Any) -> list[Fraction]:
        """Times in the unit in which the motion's numbers are of order 1."""
        return [F(t) / self.rate for t in turns]


@functools.cache
def all_motions() -> tuple[Motion, ...]:
    """Of every family in turn, and the same ones for whoever asks."""
    return tuple(_motions())


def _motions() -> Iterator[Motion]:
    """The library's, those of the file, those by formulas."""
    table = members.motion_table()
    library: dict[str, list[Motion]] = {}
    for case, words in table.pop("library").items():
        family, _, regime = words.partition(": ")
        library.setdefault(family, []).append(Motion(family, case, regime))
    for family in library:
        yield from library[family]
        for name, texts in table.get(family, {}).items():
            yield Motion(family, name, texts[4], members.read_start(texts))
        for name, start in members.MOTIONS.get(family, {}).items():
            yield Motion(family, name, "", start)


def scene_of(
    start: Sequence[Any],
    kind: str = "auto",
    axes: Any = IDENTITY,
    unit: Fraction | int = 1,
    mass: Fraction | int = 1,
) -> polhode.Scene:
    """A scene where ``axes`` are the principal ones, in other units of time and mass."""
    moments, torque, omega, gamma = start
    inertia = [
        [sum(mass * moments[k] * axes[k][i] * axes[k][j] for k in range(3)) for j in range(3)]
        for i in range(3)
    ]
    torque = in_scene([mass * unit * unit * x for x in torque], axes)
    body = polhode.Body(inertia, torque, 1 if any(torque) else 0)
    omega, gamma = in_scene([unit * x for x in omega], axes), in_scene(gamma, axes)
    return polhode.Scene(body, omega, gamma, psi=PSI, times=(1,), reference=kind)


def in_scene(v: Sequence[Any], axes: Any) -> list[Any]:
    """A vector in the scene's axes, whose components along ``axes`` are given."""
    return [sum(axes[i][j] * v[i] for i in range(3)) for j in range(3)]


def near_families(scene: polhode.Scene) -> dict[str, str]:
    """What ``show`` says a scene is near to: families, each with the condition that fails."""
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as text:
        scene = replace(scene, reference="auto")
        (file := Path(folder) / "scene.toml").write_text(polhode.as_toml(scene))
        assert main(["show", str(file), "--json"]) == 0
    return dict(line.split(": ", 1) for line in json.loads(text.getvalue()).get("near", []))


def relabel(start: Sequence[Any], order: Sequence[int], signs: Sequence[int]) -> tuple[Any, ...]:
    """The same motion in axes of other names and senses: w is axial, the rest polar."""
    polar = tuple(tuple(s * row[i] for s, i in zip(signs, order, strict=True)) for row in start[1:])
    side = signs[0] * signs[1] * signs[2] * (1 if tuple(order) in EVEN else -1)
    moments = tuple(start[0][i] for i in order)
    return moments, polar[0], tuple(side * x for x in polar[1]), polar[2]


def start_quaternion(scene: polhode.Scene) -> list[mpf]:
    """Of Rz(psi) Rx(theta) Rz(phi), phi = atan2(gamma1, gamma2); the first part not 0 is above 0.

    At the precision in force; the smaller of cos and sin of theta/2 without loss.
    """
    g1, g2, g3 = map(number, scene.gamma)
    psi, across = number(scene.psi), mpmath.hypot(g1, g2)
    phi = mpmath.atan2(g1, g2) if across else mpf(0)
    large = mpmath.sqrt((1 + abs(g3)) / 2)
    c, s = (large, across / large / 2) if g3 > 0 else (across / large / 2, large)
    parts = turns_of(psi, phi, c, s)
    first = next(x for x in parts if abs(x) > mpmath.eps * 2**20)
    return [x if first > 0 else -x for x in parts]


def by_series(
    motion: Motion, times: Sequence[Fraction], digits: int, attitude: bool = True
) -> list[list[Any]]:
    """Rows w, gamma [, q0...q3 [, growth of arg(q0 + iq3), of arg(q1 + iq2)]], by power series.

    Times lead away from 0.  The growths only where the scene's axes are the principal ones.
    """
    scene, unit = motion.scene, motion.rate
    speed = max(map(abs, scene.omega)) / unit
    digits += max(0, math.ceil(-exact.log10(speed))) if speed else 0
    with mpmath.workdps(digits + 150):  # a row's tiny numbers are no rounding
        turn = start_quaternion(scene) if attitude else None
        gamma, omega = [*map(number, scene.gamma)], [number(x / unit) for x in scene.omega]
        body = scene.body
    with mpmath.workdps(digits + 60):
        moments, axes = principal_axes(motion)
        torque = [number(x / unit**2) / moments[0] for x in body.torque]
        vectors = [[mpmath.fdot(axis, v) for axis in axes] for v in (torque, omega, gamma)]
        vectors = [x / moments[0] for x in moments], *vectors, [number(t * unit) for t in times]
        principal = motion.principal is not None
        begin = turn if principal or not attitude else [1, 0, 0, 0]
        rows = fast_series.integrate(*vectors, digits + 8, begin)
        if not principal:
            for row in rows:
                row[:6] = [*in_scene(row[:3], axes), *in_scene(row[3:6], axes)]
                if attitude:
                    back = [turn[0], *(-x for x in turn[1:])]
                    row[6:] = turn_between([row[6], *in_scene(row[7:10], axes)], back)
        return [[*(x * number(unit) for x in row[:3]), *row[3:]] for row in rows]


def principal_axes(motion: Motion) -> tuple[list[mpf], list[list[mpf]]]:
    """Moments, and the axes as rows; those of a tensor are mpmath's, not the package's."""
    body = motion.scene.body
    if motion.principal is not None:
        return [number(x) for x in body.moments], [[mpf(x) for x in axis] for axis in IDENTITY]
    tensor = mpmath.matrix([[number(x) for x in row] for row in body.inertia])
    moments, columns = mpmath.eigsy(tensor)
    first, second, third = columns.T.tolist()
    return list(moments), [first, second, [mpmath.det(columns) * x for x in third]]


def gap(first: Sequence[Any], second: Sequence[Any]) -> mpf:
    """The largest difference of two rows."""
    with mpmath.workdps(400):
        return max(abs(mpf(x) - mpf(y)) for x, y in zip(first, second, strict=True))


def table_gap(first: Sequence[Any], second: Sequence[Any], rate: Any = 1) -> mpf:
    """The largest difference of two tables of states: w over its largest value, or ``rate``."""
    with mpmath.workdps(400):
        largest = max(abs(mpf(x)) for row in (*first, *second) for x in row[:3])
        scale = largest if largest > number(rate) * mpf("1e-45") else number(rate)
        return max(
            max(gap(a[:3], b[:3]) / scale, gap(a[3:], b[3:]) if len(b) > 3 else mpf(0))
            for a, b in zip(first, second, strict=True)
        )


def quaternion_of(psi: Any, theta: Any, phi: Any) -> list[mpf]:
    """Of Rz(psi) Rx(theta) Rz(phi); one of both signs."""
    return turns_of(psi, phi, mpmath.cos(theta / 2), mpmath.sin(theta / 2))


def turns_of(psi: Any, phi: Any, c: Any, s: Any) -> list[mpf]:
    """The same, by the cosine and the sine of theta/2."""
    scalar_and_third, rest = c * mpmath.expj((psi + phi) / 2), s * mpmath.expj((psi - phi) / 2)
    return [scalar_and_third.real, rest.real, rest.imag, scalar_and_third.imag]


def vertical_of(q: Sequence[Any]) -> list[mpf]:
    """The vertical in the body's axes: the third row of the rotation."""
    a, x, y, z = q
    return [2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z]


def turn_between(q: Sequence[Any], start: Sequence[Any]) -> list[Any]:
    """start^-1 q: the turn since the start, scalar and vector in the body's axes."""
    a, x, y, z = start[0], -start[1], -start[2], -start[3]
    b, u, v, w = q
    return [
        a * b - x * u - y * v - z * w,
        a * u + x * b + y * w - z * v,
        a * v - x * w + y * b + z * u,
        a * w + x * v - y * u + z * b,
    ]


# -- what is asked of every closed form in balls: few bits against many, a Taylor run

F = Fraction
BALLS_PSI = F(3, 7)
FEW_BITS = 24, 30, 40, 53, 64, 90, 128, 200, 330
TIMES = F(3, 2), F(-7), F(1000)


def motion_of_family(family, plain):
    moments, torque, omega, gamma = plain
    body = polhode.Body.of_moments(moments, torque, 1 if any(torque) else 0)
    kind, motion = closed_form(polhode.Scene(body, omega, gamma, psi=BALLS_PSI), family)
    assert kind == family
    return motion


def form(family, moments, torque, omega, gamma, psi=exact.ZERO, axes=None):
    """The closed form of a family, or of one by its name, of any exact numbers."""
    if isinstance(family, str):
        (family,) = (member for member in FAMILIES if member.name == family)
    into = MotionAxes(within=axes).into
    scene = PrincipalScene(moments, torque, into(omega), into(gamma))
    return form_of(family, scene, (omega, gamma, psi), axes)


def row_at(motion, t, bits):
    """The balls of so many bits, whatever their radii; None where they do not tell."""
    with ctx.workprec(bits):
        try:
            return motion.row_at(ball(t), attitude=motion.place.has_attitude)[0]
        except TooFewBits:
            return None


def every_ball_holds_its_value(motion, times=TIMES, few=FEW_BITS, many=900, sure_to="1e-60"):
    """Says how many were finite; those of many bits are ``sure_to`` so much."""
    finite = 0
    for t in times:
        sure = row_at(motion, t, many)
        assert sure is not None
        assert all(x.is_finite() and x.rad() < arb(sure_to) for x in sure[3:])
        for bits in few:
            for x, y in zip(row_at(motion, t, bits) or (), sure, strict=False):
                if x.is_finite():
                    assert x.overlaps(y), (t, bits)
                    finite += 1
    return finite


def agrees_with_taylor(motion, plain, digits=28):
    """The state, and the attitude of a family that has it; the run is long where |w| is large."""
    t, columns = TIMES[0], 6 + 4 * motion.place.has_attitude
    identity = (mpf(1), mpf(0), mpf(0), mpf(0)) if motion.place.has_attitude else None
    (row,) = ordinary(motion.at([t], digits + 4))
    with mpmath.workdps(60):
        start = [[number(x) for x in row] for row in plain]
        (right,) = fast_series.integrate(*start, [number(t)], digits + 2, identity)
        largest = max([mpf(1), *(abs(x) for x in right[:3])])
        if motion.place.has_attitude:
            q0, q = ordinary(motion.attitude([0, t], digits + 4))
            row = [*row, *quaternion_product(conjugate(q0), q)]
        sizes = [*[largest] * 3, *[1] * (columns - 3)]
        off = [abs(x - y) / size for x, y, size in zip(row, right[:columns], sizes, strict=True)]
        assert max(off) < mpf(10) ** -digits
