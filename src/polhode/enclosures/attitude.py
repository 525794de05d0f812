"""The attitude and the angles along the exact motion, as balls.

Trusted. In the scene's body axes, with U the turn since the start (``quaternion``) and A the
principal axes, rows of the matrix from the scene's axes to them,

    q(t) = q(0) (U_0, A^T U_v),    q(0) = Rz(psi) Rx(theta) Rz(phi) at the start,

both factors unit quaternions, so that the distance of U from its midpoint is that of q. theta
and phi come from gamma, psi from the third axis in space, both up to whole turns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from polhode.common.interrupts import NONE, Deadline
from polhode.enclosures import quaternion
from polhode.enclosures.fixed_point_problem import TIME_BITS, ExactMotion, Problem, sharp
from polhode.enclosures.polynomial import ball
from polhode.enclosures.quaternion import Turned
from polhode.enclosures.step_bound import Bounds
from polhode.enclosures.zonotope import Step, inside, places
from polhode.equations.kinematics import departure, phi_leaving_the_pole, starting_attitude
from polhode.numbers.exact import arctan2
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Complexes, Doubles
from polhode.numbers.vectors import quaternion_product, vertical

# --- turns ----------------------------------------------------------------------------------------
#
# How often psi and phi have gone round: by continuity, in doubles, from node to node of a step.
# This is not proven, and no digit rests on it: the balls tell both angles up to whole turns.


_FIRST, _MOST = 8, 100_000  # nodes of a step
_SMOOTH = 1.0  # radians that an angle may grow from node to node
_LEAST = 1e-13  # of a step, between nodes: nearer a pole doubles do not tell its side


class Followed:
    """psi and phi along the motion, by continuity from the start.

    ``begin``: those at the start, at a pole those with which it is left; None where it has none.
    ``lost``: the time at whose step they were, in the proof's unit; None while they are not.
    """

    def __init__(self, begin: tuple[float, float] | None) -> None:
        self.total = np.array(begin or (0.0, 0.0))
        self.lost: float | None = 0.0 if begin is None else None
        self._walked = 0.0

    def step(self, at: Any, length: float, points: Any) -> Any:
        """The angles at the points ``points`` of a step; None where they are lost.

        ``at``: an array of tau in [0, 1] to sin(theta) exp i psi and sin(theta) exp i phi, (2, n).
        """
        if self.lost is not None:
            return None
        nodes = np.unique(np.concatenate([np.linspace(0.0, 1.0, _FIRST + 1), points]))
        while True:
            values = at(nodes)
            values[:, 0] = np.exp(1j * self.total)  # known, also where the numbers are 0
            grown = np.angle(values[:, 1:] * values[:, :-1].conj())
            at_zero = (values == 0).any(axis=0)
            rough = (np.abs(grown) > _SMOOTH).any(axis=0) | at_zero[1:] | at_zero[:-1]
            if not rough.any():
                break
            if nodes.size > _MOST or np.diff(nodes)[rough].min() < _LEAST:
                self.lost = self._walked
                return None
            middle = 0.5 * (nodes[:-1] + nodes[1:])[rough]
            nodes = np.sort(np.concatenate([nodes, middle]))
        along = np.concatenate([np.zeros((2, 1)), np.cumsum(grown, axis=1)], axis=1)
        along += self.total[:, None]
        self.total = along[:, -1].copy()
        self._walked += length
        return along[:, np.searchsorted(nodes, points)].T


# --- attitude -------------------------------------------------------------------------------------


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
        motion: ExactMotion,
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
        self._start = [sharp(x, bits) for x in start]
        axes = scene.body.axes
        self._axes = None if axes.trivial else [[ball(x, bits) for x in row] for row in axes.rows]
        self._turn = np.array([[float(x) for x in row] for row in axes.rows])
        self._first = np.array([float(x.mid()) for x in self._start])
        self.followed = self._beginning(motion) if angles else Followed(None)

    def _beginning(self, motion: ExactMotion) -> Followed:
        """psi and phi at the start; just after it where that is at a pole.

        There psi + phi, at the lower pole psi - phi, is the psi given.
        """
        scene = motion.scene
        assert scene.gamma is not None
        psi = float(scene.psi)
        if not scene.starts_at_pole:
            return Followed((psi, float(arctan2(scene.gamma[0], scene.gamma[1]))))
        if departure(scene) is None:
            return Followed(None)
        phi = phi_leaving_the_pole(scene, -1 if motion.backward else 1)
        return Followed((psi - float(scene.gamma[2]) * phi, phi))

    def window(self, bounds: Bounds, steps: Sequence[Step]) -> None:
        """A window whose steps have been accepted."""
        pieces = bounds.pieces
        turns = quaternion.turns(bounds, steps, self.solution)
        times = inside(self.times[len(self.poses) :], pieces.times[-1])
        with ctx.workprec(TIME_BITS):
            where = places(pieces.times, times)
        for n in range(len(steps)):
            self.deadline.check()
            taus = where.get(n, [])
            followed = self._follow(bounds, turns, n, taus)
            for k, tau in enumerate(taus):
                about = None if followed is None else (float(followed[k, 0]), float(followed[k, 1]))
                self.poses.append(Pose(self._scene(*self._turned.at(turns, n, tau)), about))
            self._turned.step(turns, n)

    def _follow(
        self, bounds: Bounds, turns: quaternion.TurnBounds, n: int, taus: Sequence[Any]
    ) -> Any:
        pieces = bounds.pieces
        near, v = pieces.near[n], turns.near[n]
        before = np.array([math.ldexp(x, -self.problem.fine) for x in self._turned.centre])

        def at(nodes: Doubles) -> Complexes:
            return two_numbers(nodes, near[:, 3:], v, before, self._first, self._turn)

        points = np.array([float(tau.mid()) for tau in taus])
        return self.followed.step(at, float(pieces.lengths[n]), points)

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
    nodes: Doubles, gamma: Doubles, turn: Doubles, before: Doubles, first: Doubles, axes: Doubles
) -> Complexes:
    """sin(theta) exp(i psi) and sin(theta) exp(i phi) at some tau, (2, n).

    ``gamma``: its coefficients in principal axes; ``turn``: of the turn in the step, after
    ``before`` and the start's attitude ``first``; ``axes``: the principal ones in the scene's.
    """
    powers = np.vander(nodes, max(len(gamma), len(turn)), increasing=True)
    gammas = powers[:, : len(gamma)] @ gamma @ axes
    quaternion_at = np.array(quaternion_product(before, (powers[:, : len(turn)] @ turn).T))
    q = quaternion_product(first, [quaternion_at[0], *(axes.T @ quaternion_at[1:])])
    psi = third_axis(q)
    return np.array([1j * psi[0] - psi[1], gammas[:, 1] + 1j * gammas[:, 0]])


def third_axis(q: Sequence[Any]) -> Sequence[Any]:
    """The body's third axis in space: what the opposite turn makes of the vertical."""
    return vertical((q[0], *(-x for x in q[1:])))


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
