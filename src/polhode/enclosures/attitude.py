"""The attitude and the angles along the exact motion, as balls.

Trusted. In the scene's body axes, with U the turn since the start (``quaternion``) and A the
principal axes, rows of the matrix from the scene's axes to them,

    q(t) = q(0) (U_0, A^T U_v),    q(0) = Rz(psi) Rx(theta) Rz(phi) at the start,

both factors unit quaternions, so that the distance of U from its midpoint is that of q. theta
and phi come from gamma, psi from the third axis in space; their turns from ``winding_number``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from polhode.common.interrupts import NONE, Deadline
from polhode.enclosures import quaternion
from polhode.enclosures.fixed_point_problem import TIME_BITS, UP, Motion, Problem, sharp
from polhode.enclosures.polynomial import ball
from polhode.enclosures.quaternion import Turned
from polhode.enclosures.step_bound import TINY, Bounds, gamma
from polhode.enclosures.zonotope import Step, inside, places
from polhode.equations.kinematics import departure, phi_leaving_the_pole, starting_attitude
from polhode.equations.terms import LINEAR, PRODUCTS, ROWS
from polhode.numbers.exact import arctan2
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Complexes, Doubles
from polhode.numbers.vectors import quaternion_product

# --- winding number -------------------------------------------------------------------------------
#
# How often psi and phi have gone round: complex numbers followed about 0, interval by interval.
#
# Trusted.  sin(theta) exp(i phi) = gamma2 + i gamma1 and sin(theta) exp(i psi) = i n1 - n2, n the
# body's third axis in space, are the numbers c; |c'| <= |w| and |c''| <= |w|**2 + |w'|.  Over an
# interval of length l the argument of c grows by the principal difference of the ends
#
#     if an end is farther from 0 than l |w|: c stays in a disc without 0;
#     if the chord of the ends is farther from 0 than l**2/8 sup |c''|, by which c leaves the chord.
#
# Where neither can be said the interval is halved, until it is no longer than what the ends are
# known to: the motion then passes a pole, and the angles are lost from there on.
#
# A number c that is 0 at t = 0 and leaves with c' differs from t c' by at most t**2/2 sup |c''|, so
# up to t = |c'|/sup |c''| it stays within 30 degrees of c'.  One that leaves with c'' differs from
# t**2/2 c'' by at most t**3/6 sup |c'''|, and stays within 30 degrees of c'' up to
# t = 3/2 |c''|/sup |c'''|.  For both numbers |c'| = |w x axis|, and then |c''| = |w' x axis|.
#
# In the second case w is along the third axis at t = 0.  With W >= |w|, v its part across the axis,
# Y >= |w'| up to t, and K = 1 + W t exp(W t)/2,
#
#     |c'| <= v + W |c|,    v <= t Y,    hence    |c|, |gamma x w| <= v + W |c| <= t K Y;
#     |w''| <= sqrt(2) b W |w'| + pull |gamma x w|,    hence
#     Y <= |w'(0)|/(1 - sqrt(2) b W t - pull t**2 K)    while that is positive;
#     |c'''| <= W**2 t K Y + 2 W Y + 2 t K Y**2 + |w''|.


MOST = 100_000  # points of a step
_FIRST = 8


class Pace(NamedTuple):
    """Bounds on a step: of |w|, and of |w'| <= gyration |w|**2 + pull.

    ``gyration``: the largest |(B - C)/A|; ``pull``: of I^-1 (gamma x Mg r0), |gamma| = 1.
    """

    speed: float
    gyration: float
    pull: float

    @property
    def bend(self) -> float:
        """A bound of |c''|: |w|**2 + |w'|."""
        return self.speed**2 * (1.0 + self.gyration) + self.pull


class PoleDirections(NamedTuple):
    """How a motion leaves a pole at t = 0: the directions of the two numbers, and how they grow.

    ``order``: that of their first derivative that is not 0, 1 or 2; ``size``: its modulus.
    ``rate``: of order 2, |w'|.
    """

    directions: Any
    order: int
    size: float
    rate: float = 0.0

    def until(self, pace: Pace) -> float:
        """A time up to which both numbers are within 30 degrees of their directions."""
        if self.order == 1:
            return self.size / (1.01 * pace.bend)
        time = 1.0 / pace.speed if pace.speed > 0.0 else 1.0
        while 1.01 * time * self._third(pace, time) > 1.5 * self.size:
            time *= 0.5
        return time

    def _third(self, pace: Pace, time: float) -> float:
        """sup |c'''| up to a time."""
        speed, gyration, pull = pace
        grown = 1.0 + 0.5 * speed * time * math.exp(speed * time)  # K
        gyration *= math.sqrt(2.0) * speed
        left = 1.0 - gyration * time - pull * time * time * grown
        if left <= 0.0:
            return math.inf
        rate = self.rate / left
        moved = time * grown * rate
        return speed**2 * moved + (2.0 * speed + gyration + 2.0 * moved) * rate + pull * moved


class Followed:
    """psi and phi along the motion to within a turn's fraction, by growth from the start.

    ``lost``: the time at whose step they were, in the proof's unit; None while they are not.
    ``leaving``: of a start at a pole; psi and phi are then those just after it.
    """

    def __init__(
        self, psi: float, phi: float, known: bool, leaving: PoleDirections | None = None
    ) -> None:
        self.leaving = leaving
        self.total = np.array([psi, phi])
        self.slack = 1e-9 * (1.0 + abs(psi))  # of what was added up
        self.known = known
        self.walked, self.lost = 0.0, None if known else 0.0

    def step(self, at: Any, length: float, pace: Pace, doubt: float, points: Any) -> Any:
        """The angles at the points ``points`` of a step; None where they are lost.

        ``at``: an array of tau in [0, 1] to the two complex numbers, (2, n), each right to
        ``doubt``, which holds the rounding of :func:`_chords` as well: a few units of 1.
        """
        if not self.known:
            return None
        doubt += UP * gamma(8) * length * pace.speed  # tau is a double
        first = None if self.leaving is None else min(1.0, self.leaving.until(pace) / length)
        even = np.linspace(0.0, 1.0, _FIRST + 1)
        nodes = np.unique(np.concatenate([even, points, [] if first is None else [first]]))
        while True:
            values = at(nodes)
            if first is not None and self.leaving is not None:
                values[:, nodes < first] = self.leaving.directions[:, None]
            sizes = np.abs(values) - doubt
            reach = 1.01 * length * pace.speed * np.diff(nodes) + doubt
            sure = np.maximum(sizes[:, :-1], sizes[:, 1:]) > reach
            bow = 1.01 * pace.bend * (length * np.diff(nodes)) ** 2 / 8.0 + doubt
            sure |= _chords(values) - doubt > bow
            if first is not None:
                sure[:, nodes[1:] <= first] = True
            sure &= np.minimum(sizes[:, :-1], sizes[:, 1:]) > 2.0 * doubt
            bad = ~np.all(sure, axis=0)
            if not np.any(bad):
                break
            if nodes.size > MOST or not np.all(reach[bad] > 2.0 * doubt):
                return self._lost()
            middle = 0.5 * (nodes[:-1] + nodes[1:])[bad]
            nodes = np.sort(np.concatenate([nodes, middle]))
        grown = np.angle(values[:, 1:] * np.conj(values[:, :-1]))
        self.slack += float(np.sum(4.0 * doubt / sizes)) + 1e-15 * nodes.size
        if not self.slack < 0.5:
            return self._lost()
        along = np.concatenate([np.zeros((2, 1)), np.cumsum(grown, axis=1)], axis=1)
        along += self.total[:, None]
        self.total = along[:, -1].copy()
        if not math.isfinite(float(np.sum(self.total))):
            return self._lost()
        self.leaving, self.walked = None, self.walked + length
        return along[:, np.searchsorted(nodes, points)].T

    def _lost(self) -> None:
        """From this step on they are not known."""
        self.known, self.lost = False, self.walked


def _chords(values: Any) -> Any:
    """The distances from 0 of the chords between neighbours of (2, n) complex numbers."""
    begin, chord = values[:, :-1], np.diff(values, axis=1)
    square = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    foot = np.clip(-(chord.conj() * begin).real / square, 0.0, 1.0)
    return np.abs(begin + foot * chord)


# --- attitude -------------------------------------------------------------------------------------


#: Terms of gamma in a row of w.
_PULLS = float(max(sum(term in LINEAR for term in row) for row in ROWS))


class Pose(NamedTuple):
    """At one time: the unit quaternion as four balls, and about psi and phi; None if not known."""

    quaternion: list[Any]
    turns: tuple[float, float] | None


class AttitudeWatch:
    """The attitude at times >= 0, increasing, given as balls, as the windows of a proof go by.

    ``angles``: whether psi and phi are followed too.  ``deadline``: looked at with each step.
    """

    def __init__(
        self,
        motion: Motion,
        problem: Problem,
        times: Sequence[Any],
        solution: quaternion.Solution,
        angles: bool,
        deadline: Deadline = NONE,
    ) -> None:
        self.problem, self.times, self.solution = problem, times, solution
        self.deadline = deadline
        self.poses: list[Pose] = []
        self._turned = Turned(problem)
        scene = motion.scene
        if scene.gamma is None:
            raise ValueError("a scene without gamma has no attitude")
        bits = problem.fine + 64
        start = starting_attitude(scene.gamma, scene.psi)
        self._start = [sharp(partial(ball, x), bits) for x in start]
        axes = scene.body.axes
        self._axes = None if axes.trivial else [[ball(x, bits) for x in row] for row in axes.rows]
        self._turn = np.array([[float(x) for x in row] for row in axes.rows])
        self._first = np.array([float(x.mid()) for x in self._start])
        self._followed = self._beginning(motion) if angles else Followed(0.0, 0.0, False)

    def _beginning(self, motion: Motion) -> Followed:
        """psi and phi at the start; just after it where that is at a pole.

        There psi + phi, at the lower pole psi - phi, is the psi given, and
        gamma' = gamma x w, n' = R (w x e3) tell where the two numbers go; gamma'' = gamma x w',
        n'' = R (w' x e3) where w is along the third axis.
        """
        scene = motion.scene
        assert scene.gamma is not None
        psi = float(scene.psi)
        if not scene.starts_at_pole:
            return Followed(psi, float(arctan2(scene.gamma[0], scene.gamma[1])), True)
        leaving = departure(scene)
        if leaving is None:
            return Followed(0.0, 0.0, False)
        turning = [math.ldexp(float(x), leaving.order * motion.unit) for x in leaving.vector]
        size = math.hypot(*turning[:2])
        if size == 0.0:  # too small for a double
            return Followed(0.0, 0.0, False)
        phi = phi_leaving_the_pole(scene, -1 if motion.backward else 1)
        psi -= float(scene.gamma[2]) * phi
        directions = np.exp(1j * np.array([psi, phi]))
        return Followed(
            psi, phi, True, PoleDirections(directions, leaving.order, size, math.hypot(*turning))
        )

    def window(self, bounds: Bounds, steps: Sequence[Step]) -> None:
        """A window whose steps have been accepted."""
        pieces = bounds.pieces
        turns = quaternion.turns(bounds, steps, self.solution)
        times = inside(self.times[len(self.poses) :], pieces.times[-1])
        with ctx.workprec(TIME_BITS):
            where = places(pieces.times, times)
        for n, step in enumerate(steps):
            self.deadline.check()
            taus = where.get(n, [])
            followed = self._follow(bounds, turns, n, step, taus)
            for k, tau in enumerate(taus):
                about = None if followed is None else (float(followed[k, 0]), float(followed[k, 1]))
                self.poses.append(Pose(self._scene(*self._turned.at(turns, n, tau)), about))
            self._turned.step(turns, n)

    @property
    def lost(self) -> float | None:
        """About the time at which psi and phi were lost, in the proof's unit, forward."""
        return self._followed.lost

    def _follow(
        self, bounds: Bounds, turns: quaternion.TurnBounds, n: int, step: Step, taus: Sequence[Any]
    ) -> Any:
        if not self._followed.known:
            return None
        pieces, noise = bounds.pieces, self.problem.noise
        near, v = pieces.near[n], turns.near[n]
        before = np.array([math.ldexp(x, -self.problem.fine) for x in self._turned.centre])

        def at(nodes: Doubles) -> Complexes:
            return two_numbers(nodes, near[:, 3:], v, before, self._first, self._turn)

        size = np.sum(np.abs(near[:, :3]), axis=0) + np.sum(pieces.gap[n])
        off = math.ldexp(float(bounds.sigma[n]) + step.r, -noise)
        turn = math.ldexp(self._turned.radius + float(turns.miss[n]), -noise)
        doubt = UP * 8.0 * (float(np.sum(pieces.gap[n])) + off + turn) + rounding(near[:, 3:], v)
        speed = UP * (math.sqrt(float(np.sum(size * size))) + 2.0 * off)
        points = np.array([float(tau.mid()) for tau in taus])
        return self._followed.step(at, float(pieces.lengths[n]), self._pace(speed), doubt, points)

    def _pace(self, speed: float) -> Pace:
        """|w'| <= b |w|^2 + pull from the terms of w' in products of w and in gamma.

        With b the largest coefficient of w_j w_k, of which each row has one.
        """
        factors = [
            UP * (abs(x) + r)
            for x, r in zip(self.problem.factors, self.problem.factor_slack, strict=True)
        ]
        bend = max(term.of(factors) for row in ROWS[:3] for term in row if term in PRODUCTS)
        pull = max(term.of(factors) for term in LINEAR)
        return Pace(speed, bend, 1.7321 * _PULLS * pull)

    def _scene(self, turn: Sequence[Any], radius: float) -> list[Any]:
        """The attitude of the scene from the turn since the start and its distance from that."""
        noise = self.problem.noise
        with ctx.workprec(noise + 104):
            vector = turn[1:]
            if self._axes is not None:
                vector = [sum(self._axes[i][j] * vector[i] for i in range(3)) for j in range(3)]
            quaternion_now = quaternion_product(self._start, [turn[0], *vector])
            off = arb(0, radius) * arb((1, -noise))
            return [x + off for x in quaternion_now]


def two_numbers(
    nodes: Doubles, vertical: Doubles, turn: Doubles, before: Doubles, first: Doubles, axes: Doubles
) -> Complexes:
    """sin(theta) exp(i psi) and sin(theta) exp(i phi) at some tau, (2, n).

    ``vertical``: coefficients of gamma in principal axes; ``turn``: of the turn in the step, after
    ``before`` and the start's attitude ``first``; ``axes``: the principal ones in the scene's.
    """
    powers = np.vander(nodes, max(len(vertical), len(turn)), increasing=True)
    gammas = powers[:, : len(vertical)] @ vertical @ axes
    quaternion_at = np.array(quaternion_product(before, (powers[:, : len(turn)] @ turn).T))
    q = quaternion_product(first, [quaternion_at[0], *(axes.T @ quaternion_at[1:])])
    psi = third_axis(q)
    return np.array([1j * psi[0] - psi[1], gammas[:, 1] + 1j * gammas[:, 0]])


def rounding(vertical: Doubles, turn: Doubles) -> float:
    """What doubles lose of each of :func:`two_numbers`, of K coefficients.

    Powers of tau and a sum of K products lose gamma(2 K + 2) of the sum of |coefficients|, so that
    of the turn v at most twice that in the Euclidean norm, S being the sum of |v_k|, at least 1.  A
    product of quaternions loses gamma(8) of |a| |b|, the turn to the scene's axes gamma(12), each
    factor's own rounding 3 u: all in all q is off by gamma(4 K + 50) S.  The third axis is a
    quadratic form of norm 1 in q, off by 2 S times that and gamma(6) S**2 for itself; the complex
    number of two of its components by 3/2 as much, gamma(12 K + 160) S**2.  gamma, turned likewise,
    loses less than gamma(6 K + 60) of the sum of its |coefficients|.
    """
    count = max(len(vertical), len(turn))
    size = max(1.0, UP * float(np.sum(np.linalg.norm(turn, axis=1))))
    across = float(np.sum(np.abs(vertical)))
    return UP * gamma(12 * count + 200) * (size * size + across) + TINY


def third_axis(q: Sequence[Any]) -> list[Any]:
    """The body's third axis in space."""
    return [
        2 * (q[1] * q[3] + q[0] * q[2]),
        2 * (q[2] * q[3] - q[0] * q[1]),
        q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3],
    ]


def angles(pose: Pose, gamma: Sequence[Any], bits: int) -> list[Any]:
    """psi, theta, phi as balls; psi and phi None where they are not known."""
    with ctx.workprec(bits):
        square = gamma[0] * gamma[0] + gamma[1] * gamma[1]
        across = square.sqrt() if square > 0 else arb(0).union(square.abs_upper().sqrt())
        if gamma[2] < 0:  # no branch of atan2 at the lower pole
            theta = arb.pi() - (across / -gamma[2]).atan()
        else:
            theta = arb.atan2(across, gamma[2])
        if pose.turns is None:
            return [None, theta, None]
        axis = third_axis(pose.quaternion)
        psi = _near(axis[0], -axis[1], pose.turns[0])
        phi = _near(gamma[0], gamma[1], pose.turns[1])
        return [None, theta, None] if psi is None or phi is None else [psi, theta, phi]


def _near(sine: Any, cosine: Any, about: float) -> Any:
    """The angle within pi/2 of ``about``; None where it is not known to be there."""
    turn = arb(about)
    s, c = turn.sin(), turn.cos()
    across, along = sine * c - cosine * s, cosine * c + sine * s
    return turn + (across / along).atan() if along > 0 else None
