"""The derivative of the flow along the exact motion: balls around its 6 x 6 entries.

Trusted.  With the symbols of ``step_bound``, the derivative D(tau) of the state at tau by that at
the step's start obeys D' = (A + E) D, D(0) = I, along the exact motion xhat + z, where
E = 2 h B(e + z, .).  A row of 2 B(e, v) is bend (e_a v_b + e_b v_a), or four products, so that
|2 B(e, v)| <= 2 beta |e| |v| with the same beta, and |E| <= nu = 2 h beta (sigma + r).  The exact
transition matrix Phi(tau, s) of A has |Phi| <= exp(int_s^tau |A|), D has |D(s)| <=
exp(int_0^s |A| + nu s), and variation of constants, D - Phi = int Phi(tau, s) E(s) D(s) ds, gives

    |D(tau) - V(tau)| <= rho + exp(alpha) (exp(nu) - 1) =: eps      for all tau,            (1)

for every motion of which |z| <= r is known on the step.  Jumps of the approximation do not touch D.

Product.  P = D_n ... D_0 is kept as a matrix F of doubles and an error columnwise: column c of
P - F is S xi with |xi_k| <= W_kc, one matrix S of generators with weights of its own for each
column.  A step makes F <- fl(V F), S <- [fl(V S) | I], the new generators with the weights

    n_ic = eps (|F|_c + |err|_c) + gamma(7) (|V| |F| + |V| err)_ic,    err = |S| W,         (2)

|M|_c the largest entry of column c in modulus: V's error in norm, and the rounding of two products
of matrices of six rows.  As in ``zonotope``, T gathers the V since S was last settled and H what
was born since; every SETTLED steps H becomes one box.  So errors turn and stretch with the linear
flow and nothing is wrapped: a product of matrices of balls would lose |V| at every step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.enclosures.fixed_point_problem import TIME_BITS, UP, Refused, upper
from polhode.enclosures.step_bound import TINY, Bounds, gamma
from polhode.enclosures.zonotope import MOST_COLUMNS, SETTLED, Step, inside, places
from polhode.numbers.flint_context import ctx
from polhode.numbers.rows import Doubles

_IDENTITY = np.eye(6)


class Derivative(NamedTuple):
    """Balls around the entries: doubles ``centre`` and ``radius``, (6, 6)."""

    centre: Doubles
    radius: Doubles


class Product:
    """F, S and W of the module while a proof goes on."""

    def __init__(self) -> None:
        self.centre = _IDENTITY  # F
        self.settled, self.weights = np.zeros((6, 0)), np.zeros((0, 6))
        self.turn = _IDENTITY
        self.base = np.zeros((6, 6))  # |S| W
        self.born, self.given = np.zeros((6, 6 * SETTLED)), np.zeros((6 * SETTLED, 6))
        self.count = 0

    def error(self) -> Doubles:
        """Bounds of |P - F|, entry by entry."""
        found: Doubles = UP * (np.abs(self.turn) @ self.base + self.recent()) + TINY
        return found

    def step(self, v: Doubles, eps: float) -> None:
        """P <- D P with |D - v| <= eps."""
        more = self.noise(v, eps, self.error())
        self.centre, self.turn = v @ self.centre, v @ self.turn
        count = self.count
        self.born[:, :count] = v @ self.born[:, :count]
        self.born[:, count : count + 6] = _IDENTITY
        self.given[count : count + 6] = more
        self.count = count + 6
        if self.count == self.born.shape[1]:
            self.settle()

    def at(self, v: Doubles, eps: float) -> Derivative:
        """D P with |D - v| <= eps, without going there."""
        error = self.error()
        more = self.noise(v, eps, error)
        carried = np.abs(v @ self.turn @ self.settled) @ self.weights
        recent = np.abs(v @ self.born[:, : self.count]) @ self.given[: self.count]
        # the products with v @ turn, with v @ born and with v @ turn @ settled are rounded as well
        lost = gamma(20) * (np.abs(v) @ error)
        centre, radius = v @ self.centre, UP * (carried + recent + more + lost) + TINY
        known = np.isfinite(centre) & np.isfinite(radius)
        return Derivative(np.where(known, centre, 0.0), np.where(known, radius, np.inf))

    def noise(self, v: Doubles, eps: float, error: Doubles) -> Doubles:
        """The weights (2)."""
        size = np.max(np.abs(self.centre), axis=0) + np.max(error, axis=0)
        turned = np.abs(v) @ (np.abs(self.centre) + error)
        found: Doubles = UP * (eps * size + gamma(7) * turned) + TINY
        return found

    def settle(self) -> None:
        """H becomes one box among the settled generators."""
        recent = self.recent()
        box = recent + gamma(7) * (np.abs(self.turn) @ self.base)
        self.settled = np.hstack([self.turn @ self.settled, _IDENTITY])
        self.weights = np.vstack([self.weights, UP * box + TINY])
        self.base = UP * (np.abs(self.settled) @ self.weights) + TINY
        self.turn, self.count = _IDENTITY, 0
        if self.settled.shape[1] > MOST_COLUMNS:
            raise Refused("the derivative's error has too many columns")

    def recent(self) -> Doubles:
        """|H| times its weights."""
        found: Doubles = np.abs(self.born[:, : self.count]) @ self.given[: self.count]
        return found


class Derivatives:
    """The derivative at times >= 0, increasing, given as balls, as the windows of a proof go by."""

    def __init__(self, times: Sequence[arb]) -> None:
        self.times = times
        self.found: list[Derivative] = []
        self._product = Product()

    def window(self, known: Bounds, steps: Sequence[Step]) -> None:
        """A window whose steps have been accepted."""
        asked = inside(self.times[len(self.found) :], known.pieces.times[-1])
        with ctx.workprec(TIME_BITS):
            where = places(known.pieces.times, asked)
        for n, step in enumerate(steps):
            eps = missed(known, n, step)
            for tau in where.get(n, []):
                v, lost = matrix(known, n, tau)
                self.found.append(self._product.at(v, UP * (eps + lost)))
            self._product.step(known.ends[n], eps)


def missed(known: Bounds, n: int, step: Step) -> float:
    """eps of (1); raises Refused where it is no number."""
    problem = known.problem
    off = math.ldexp(float(known.sigma[n]) + step.r, -problem.noise)
    nu = UP * 2.0 * float(known.pieces.lengths[n]) * problem.beta * off + TINY
    if not nu <= 1.0:
        raise Refused("the set has grown too large for the derivative of the flow")
    found = UP * (float(known.rho[n]) + float(known.majorant[n]) * (nu + nu * nu)) + TINY
    if not found < 1e300:
        raise Refused("the derivative of a step has no bound")
    return found


def matrix(known: Bounds, n: int, tau: arb) -> tuple[Doubles, float]:
    """V at tau in step n as doubles, and what these miss of it in norm."""
    v = known.matrices[n]
    terms = v.shape[0]
    near = float(tau.mid())
    with ctx.workprec(64):
        off = upper(tau - arb(near))
    powers = np.cumprod(np.concatenate([[1.0], np.full(terms - 1, near)]))
    lost = gamma(2 * terms + 6) + UP * terms * off  # |V(tau) - V(near)| <= sum k |V_k| off
    return np.tensordot(powers, v, axes=1), UP * lost * float(known.sizes[n])
