"""Quaternion, psi and phi at a run's outputs, from what its panels turn by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from polhode.equations import quaternion_products, spinors
from polhode.equations.attitude_phase import Turned
from polhode.numbers.rows import Doubles, Extendeds, Flat, LongComplexes, flat
from polhode.numbers.scalars import Scalar
from polhode.runs._observers.protocol import CannotObserve
from polhode.runs.problem.problem import Problem

_PI = 4 * np.arctan(np.longdouble(1))
_DOUBT = 0.6  # of a radian, by which turns counted roughly may differ from what is known


def rows(problem: Problem, parts: Sequence[Turned], states: Flat, times: Flat) -> Flat:
    """Quaternion, psi and phi, as asked for, at outputs with these states and |times|.

    Each output is the start or the end of a panel.  Raises CannotObserve where psi and phi of a
    panel contradict its spinors.
    """
    first, start_psi = problem.attitude[:4], problem.attitude[4]
    axes = None if problem.turn is None else quaternion_products.of_matrix(problem.turn, np.sqrt)
    begun = first if axes is None else quaternion_products.product(first, _conjugate(axes))
    panels = _joined(parts)
    z = _spinors(spinors.spinor(begun), panels)
    if axes is not None:
        z = spinors.spinor(quaternion_products.product(spinors.quaternion(z), axes))
    at = np.searchsorted(np.abs(panels.begin), times)
    gamma = [*flat(problem.read.states(states))[:, 3:].T.astype(np.longdouble)]
    found = []
    if "attitude" in problem.scene.modelled:
        whole = np.array(quaternion_products.upright(spinors.quaternion(z[:, at]), gamma, np.sqrt))
        whole[:, times == 0] = first[:, None]
        found += [*whole]
    if "angles" in problem.scene.modelled:
        across = np.concatenate([panels.across[0, :1], panels.across[1]])
        psi = _whole(np.angle(-1j * z[0] * z[1]), panels.psi, start_psi)
        phi = _whole(np.angle(across), panels.phi, None)
        found += [psi[at], phi[at]]
    table: Extendeds = np.array(found).T
    return table if states.dtype == np.longdouble else table.astype(np.float64)


def _conjugate(q: Sequence[Scalar] | Extendeds) -> list[Scalar]:
    return [q[0], -q[1], -q[2], -q[3]]


def _joined(parts: Sequence[Turned]) -> Turned:
    """All panels in the order of their times."""
    joined = [np.concatenate(some, axis=-1) for some in zip(*parts, strict=True)]
    order = np.argsort(np.abs(joined[0]))
    return Turned(*(x[..., order] for x in joined))


def _spinors(start: LongComplexes, panels: Turned) -> LongComplexes:
    """The attitude at all panels' ends, the start's before them."""
    z = np.concatenate([start[:, None], panels.last[:, :-1]], axis=1)
    over = spinors.product(panels.first, z)
    phase = np.cumprod(over / np.abs(over) * panels.phase)
    return np.concatenate([start[:, None], phase / np.abs(phase) * panels.last], axis=1)


def _whole(principal: Extendeds, grown: Doubles, start: np.longdouble | None) -> Extendeds:
    """An angle with all its half turns at the panels' ends; whole ones but over a pole."""
    change = np.diff(principal)
    halves = np.rint((grown - change) / _PI)
    if (np.abs(grown - change - halves * _PI) > _DOUBT).any():
        raise CannotObserve("turns of angles and spinors differ")
    first = 0 if start is None else np.rint((start - principal[0]) / _PI)
    found: Extendeds = principal + np.concatenate([[first], first + np.cumsum(halves)]) * _PI
    return found
