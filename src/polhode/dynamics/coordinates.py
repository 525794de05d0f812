"""States on a section of a level, from the section's own coordinates, and the way back.

*momentum*: extrema of |G| where r0, G and the vertical lie in one plane. With e3 = r0/|r0|, G =
(sqrt(G^2 - L^2) sin l, sqrt(G^2 - L^2) cos l, L); l and L are canonical there: dl dL is
preserved. For l and sig = L/G, e = G/|G|, kappa = e.I^-1 e, n = (e3 - sig e)/sqrt(1 - sig^2):

    kappa (f^2 + y^2)/2 + Mg|r0| (f sig + y sqrt(1 - sig^2))/R = h,    R = |G| = sqrt(f^2 + y^2)
    gamma = (f/R) e + (y/R) n

has 0, 2 or 4 roots y (0, 1 or 2 for f = 0). R is a root of a polynomial of degree 6.

*height*: extrema of r0.gamma, states of the start form (polhode.scenes.body_and_start). Its
coordinates are the azimuth of gamma about e3 and u = gamma.e3.

Without weight e3 is the third principal axis, and y = ±sqrt(2h/kappa - f^2).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.motion.frame import Frame
from polhode.numbers import exact
from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, Doubles, Indices
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene

# --- initial tangents -----------------------------------------------------------------------------
#
# The tangents that a growth is followed from, one a motion.


SEED = 18


def tangents_of(
    starts: Doubles, moments: Doubles, torques: Doubles, alike: bool = False
) -> Doubles:
    """Unit tangents across the flow and the gradients of h, f and |gamma|^2, else at random.

    ``alike``: the random part is the same for all, so that none depends on the others.
    """
    shape = starts.shape[1:] if alike else starts.shape
    tangents = np.random.default_rng(SEED).normal(size=shape) + 0 * starts
    w, g = starts[:, :3], starts[:, 3:]
    G = w * moments
    zero = np.zeros_like(g)
    flow = np.concatenate(
        [(np.cross(g, torques) - np.cross(w, G)) / moments, np.cross(g, w)], axis=1
    )
    across = [
        np.concatenate([G, torques], axis=1),
        np.concatenate([g * moments, G], axis=1),
        np.concatenate([zero, g], axis=1),
        flow,
    ]
    basis: list[Doubles] = []
    for vector in across:  # Gram and Schmidt, twice
        for _ in range(2):
            for direction in basis:
                vector = vector - (vector * direction).sum(axis=1)[:, None] * direction
        size = np.sqrt((vector * vector).sum(axis=1))[:, None]
        basis.append(np.where(size > 1e-12, vector / np.maximum(size, 1e-300), 0.0))
    for _ in range(2):
        for direction in basis:
            tangents = tangents - (tangents * direction).sum(axis=1)[:, None] * direction
    unit: Doubles = tangents / np.sqrt((tangents * tangents).sum(axis=1))[:, None]
    return unit


# --- coordinates ----------------------------------------------------------------------------------


_BLOCK = 5000  # points whose roots numpy is asked for at once: a tenth of a second
_LARGEST = 1e50  # of |G|, and 1 over its least: sixth powers stay in the range of doubles
_FASTEST = 1e15  # |w|, and 1 over its least: so do those of 20th order in a Taylor step
_ALIKE = 4  # powers of two by which a level's fastest rate may differ from 1


class Ground(NamedTuple):
    """A body and a level as doubles, in principal axes and the run's unit of time.

    Moments, torque, h and f are in the scene's unit of mass, or where that is far from the body's,
    all divided by one power of 2**64: products of several stay in the range of doubles.
    ``frame``: rows e1, e2, e3.  ``weight``: Mg|r0|, its sign that of Mg; 0 without a moment.
    """

    moments: Doubles
    frame: Doubles
    weight: float
    h: float
    f: float

    @property
    def torque(self) -> Doubles:
        """Mg r0."""
        torque: Doubles = self.weight * self.frame[2]
        return torque

    @property
    def largest_momentum(self) -> float:
        """A bound of |G| on the level."""
        return float(np.sqrt(max(0.0, 2 * self.moments.max() * (self.h + abs(self.weight)))))

    @property
    def fastest(self) -> float:
        """A bound of |w| on the level."""
        return float(np.sqrt(max(0.0, 2 * (self.h + abs(self.weight)) / self.moments.min())))

    @property
    def slower(self) -> int:
        """The power of two by which the level's own unit of time is longer than the run's.

        0 unless by far: the run's is that of the scene's start, which may be on another level.
        """
        exponent = math.frexp(self.fastest)[1] - 1
        return -exponent if abs(exponent) > _ALIKE else 0


def ground(scene: Scene, h: Exact, f: Exact) -> Ground:
    """Of a scene's body on the level (h, f); raises BadInput for an h that doubles cannot hold."""
    body, unit = scene.body, Frame.of(scene).unit
    mantissa, exponent = exact.rounded(max(body.moments), 8)
    mass = Fraction(2) ** -(64 * round((exponent + mantissa.bit_length()) / 64))
    moments = np.array([to_double(mass * a) for a in body.moments])
    arm = body.axes.components(body.centre)
    weight = 0.0
    centre = np.array([0.0, 0.0, 1.0])
    if not body.torque_free:
        size = exact.sqrt(dot(arm, arm))
        weight = to_double(mass * unit * unit * body.weight * size)
        centre = np.array([to_double(x / size) for x in arm])
    wide = to_extended(mass * unit * unit * h), to_extended(mass * unit * f)
    level = Ground(moments, _frame(centre), weight, float(wide[0]), float(wide[1]))
    momentum, speed = level.largest_momentum, level.fastest
    if not (1 / _LARGEST < momentum < _LARGEST and 1 / _FASTEST < speed < _FASTEST):
        scale = 2 * mass * unit * unit
        bounds = (_LARGEST, 1 / Fraction(moments.max())), (_FASTEST, Fraction(moments.min()))
        most = to_double(min(Fraction(top) ** 2 * a for top, a in bounds) / scale)
        least = to_double(max(a / Fraction(top) ** 2 for top, a in bounds) / scale)
        expected = f"of a size that doubles have room for: from {least:.3g} to {most:.3g}"
        raise BadInput(scene.name, "h", shown(h), expected)
    return level


def _frame(e3: Doubles) -> Doubles:
    """e1 and e2 principal axes in cyclic order where e3 is one, else e1 across the axis that e3 is
    least along."""
    along = np.flatnonzero(e3)
    if len(along) == 1:
        k = int(along[0])
        e1, e2 = np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
        return np.array([e1, e2 if e3[k] > 0 else -e2, e3])
    axis = np.eye(3)[int(np.argmin(np.abs(e3)))]
    e1 = np.cross(axis, e3)
    e1 = e1 / np.linalg.norm(e1)
    return np.array([e1, np.cross(e3, e1), e3])


class Found(NamedTuple):
    """States (n, 6) and which of the asked coordinates each belongs to."""

    states: Doubles
    of: Indices


def momentum_states(on: Ground, l: Doubles, sig: Doubles, maxima: bool) -> Found:
    """All states at (l, L/G) that are maxima of |G| (or minima), by rising y for each."""
    parts = [
        _momentum_states(on, l[k : k + _BLOCK], sig[k : k + _BLOCK], maxima)
        for k in range(0, max(1, len(l)), _BLOCK)
    ]
    of = [part.of + k * _BLOCK for k, part in enumerate(parts)]
    return Found(np.concatenate([part.states for part in parts]), np.concatenate(of))


def _momentum_states(on: Ground, l: Doubles, sig: Doubles, maxima: bool) -> Found:
    across = np.sqrt(1 - sig * sig)
    e = (across * np.sin(l))[:, None] * on.frame[0] + (across * np.cos(l))[:, None] * on.frame[1]
    e = e + sig[:, None] * on.frame[2]
    n = (on.frame[2] - sig[:, None] * e) / across[:, None]
    kappa = (e * e / on.moments).sum(axis=1)
    y = _roots(on, kappa, sig, across)
    rows, columns = np.nonzero(np.isfinite(y))
    y, e, n = y[rows, columns], e[rows], n[rows]
    size = np.hypot(on.f, y)
    gamma = (on.f / size)[:, None] * e + (y / size)[:, None] * n
    states = np.concatenate([size[:, None] * e / on.moments, gamma], axis=1)
    kind = momentum_slope(on, states) < 0
    extremal = kind if maxima else ~kind
    return Found(states[extremal], rows[extremal])


def _roots(on: Ground, kappa: Doubles, sig: Doubles, across: Doubles) -> Doubles:
    """The y of each point, ascending, nan where there are fewer: an array (n, 4 or more)."""
    h, f, weight = on.h, on.f, on.weight
    if weight == 0:
        square = 2 * h / kappa - f * f
        size = np.sqrt(np.where(square > 0, square, np.nan))
        return np.stack([-size, size], axis=1)
    # with u = R/scale: (kappa R^3/2 - h R + P f sig)^2 - P^2 across^2 (R^2 - f^2) = 0
    scale = on.largest_momentum or 1.0
    a, b, c = kappa * scale**3 / 2, -h * scale + 0 * kappa, weight * f * sig
    d = (weight * across) ** 2
    zero = 0 * kappa
    coefficients = [a * a, zero, 2 * a * b, 2 * a * c, b * b - d * scale**2, 2 * b * c]
    coefficients.append(c * c + d * f * f)
    companion = np.zeros((len(kappa), 6, 6))
    companion[:, 0, :] = -np.stack(coefficients[1:], axis=1) / coefficients[0][:, None]
    companion[:, np.arange(1, 6), np.arange(5)] = 1
    roots = np.linalg.eigvals(companion)
    real = np.abs(roots.imag) < 1e-5 * np.maximum(np.abs(roots.real), 1e-3)
    size = np.where(real & (roots.real > 0), roots.real * scale, np.nan)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(np.maximum(size * size - f * f, 0))
        side = -((kappa[:, None] * size**3 / 2 - h * size) + (weight * f * sig)[:, None]) / weight
        y = np.where(side < 0, -root, root)
        for _ in range(6):  # Newton's method on the equation itself
            excess, slope = _excess(on, y, kappa, sig, across)
            y = y - excess / slope
        wrong = np.abs(_excess(on, y, kappa, sig, across)[0]) > 1e-12 * (abs(h) + abs(weight))
        y = np.where(wrong | (np.hypot(y, f) < 1e-9 * scale), np.nan, y)
    y = np.sort(y, axis=1)  # nan last
    twice = np.diff(y, axis=1, prepend=-np.inf) < 1e-9 * scale
    y[twice] = np.nan
    return np.sort(y, axis=1)


def _excess(
    on: Ground, y: Doubles, kappa: Doubles, sig: Doubles, across: Doubles
) -> tuple[Doubles, Doubles]:
    """By how much the energy at y exceeds h, and its derivative."""
    size = np.hypot(on.f, y)
    k, s, c = kappa[:, None], sig[:, None], across[:, None]
    excess = k * size**2 / 2 + on.weight * (on.f * s + y * c) / size - on.h
    return excess, k * y + on.weight * (c * on.f**2 - on.f * s * y) / size**3


def momentum_slope(on: Ground, states: Doubles) -> Doubles:
    """Mg D' at states on the section: below 0 for a maximum of |G|."""
    w, g = states[:, :3], states[:, 3:]
    momentum, e3 = w * on.moments, on.frame[2]
    twice = (w * momentum).sum(axis=1)
    if on.weight == 0:  # D' = gamma'.(e3 x G) + gamma.(e3 x G'), G' = G x w
        turning = np.cross(g, w)
        by = (turning * np.cross(e3, momentum)).sum(axis=1)
        slope: Doubles = by + (g * np.cross(e3, np.cross(momentum, w))).sum(axis=1)
        return slope
    across = np.cross(e3, g)
    slope = twice * (g @ e3) - (g * w).sum(axis=1) * (momentum @ e3)
    slope = on.weight * (slope + on.weight * (across * across).sum(axis=1))
    return slope


def height_states(on: Ground, gamma: Doubles, side: Doubles, maxima: bool) -> Found:
    """The state of each gamma (n, 3) and sign, where it is on the level and such an extremum."""
    inertial = gamma * on.moments
    inertia = (gamma * inertial).sum(axis=1)
    v = np.cross(inertial, np.cross(gamma, on.frame[2]))
    spare = on.h - on.f**2 / (2 * inertia) - gamma @ on.torque
    with np.errstate(invalid="ignore", divide="ignore"):
        size = side * np.sqrt(2 * spare / (v * v * on.moments).sum(axis=1))
        w = (on.f / inertia)[:, None] * gamma + size[:, None] * v
    states = np.concatenate([w, gamma], axis=1)
    there = np.isfinite(states).all(axis=1)
    kind = np.zeros(len(gamma), dtype=bool)
    kind[there] = height_bend(on, states[there]) < 0
    extremal = there & (kind if maxima else ~kind)
    return Found(states[extremal], np.flatnonzero(extremal))


def height_bend(on: Ground, states: Doubles) -> Doubles:
    """The second derivative of gamma.e3, of Mg r0.gamma where there is a weight."""
    w, g = states[:, :3], states[:, 3:]
    turning = (np.cross(g, on.torque) - np.cross(w, w * on.moments)) / on.moments
    second = np.cross(np.cross(g, w), w) + np.cross(g, turning)
    bend: Doubles = second @ (on.torque if on.weight else on.frame[2])
    return bend


def coordinates(on: Ground, states: Doubles) -> tuple[Doubles, Doubles]:
    """l in [0, 2 pi) and L/G of states (..., 6)."""
    momentum = states[..., :3] * on.moments
    size = np.sqrt((momentum * momentum).sum(axis=-1))
    first, second, third = (momentum @ axis for axis in on.frame)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.mod(np.arctan2(first, second), 2 * np.pi), third / size


def height_coordinates(on: Ground, states: Doubles) -> tuple[Doubles, Doubles]:
    """The azimuth of gamma about e3 in [0, 2 pi), from e2 towards e1, and u = gamma.e3."""
    gamma = states[..., 3:]
    first, second, third = (gamma @ axis for axis in on.frame)
    return np.mod(np.arctan2(first, second), 2 * np.pi), third


def turned(scene: Scene, states: Doubles, back: bool = False) -> Doubles:
    """States (..., 6) from principal axes and the run's unit of time into the scene's; or back."""
    frame = Frame.of(scene)
    rows, unit = frame.matrix(DOUBLE), float(frame.unit)
    if back:
        rows, unit = rows.T, 1 / unit
    return np.concatenate([states[..., :3] @ rows / unit, states[..., 3:] @ rows], axis=-1)


def cells(first: int, second: int) -> tuple[Doubles, Doubles]:
    """The centres of a grid's cells: an angle in [0, 2 pi) and a cosine in (-1, 1)."""
    angle = (np.arange(first) + 0.5) * 2 * np.pi / first
    cosine = -1 + (np.arange(second) + 0.5) * 2 / second
    grid = np.meshgrid(angle, cosine, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def gamma_at(on: Ground, azimuth: Doubles, u: Doubles) -> Doubles:
    """The unit vector of an azimuth about e3 and a cosine."""
    across = np.sqrt(1 - u * u)
    gamma = (across * np.sin(azimuth))[:, None] * on.frame[0]
    gamma = gamma + (across * np.cos(azimuth))[:, None] * on.frame[1]
    gamma = gamma + u[:, None] * on.frame[2]
    return np.asarray(gamma)
