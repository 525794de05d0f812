"""First integrals, written once for any scalar, and their drift along a trajectory.

In principal axes, (3.30) and the fourth integral where the exact scene has one:

    h = ½ w·I w + Mg r0·gamma,    f = I w·gamma,    |gamma|² = 1

    |G|² = |I w|²                                   no torque (Euler)
    spin = w·n                                      symmetric about n, r0 along n (Lagrange)
    K² = |(w1 + i w2)² - (c1 + i c2)(gamma1 + i gamma2)|²,  c = Mg r0/C
                                                    A = B = 2C, r0 in the equator (Kovalevskaya)
    F = w3 (w1² + w2²) - (c1 w1 + c2 w2) gamma3     A = B = 4C, r0 in the equator, f = 0
                                                    (Goryachev, Chaplygin)

C is the moment about the axis of symmetry, which is axis 3 in these formulas.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.motion.frame import Frame
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_extended, to_mpf
from polhode.numbers.double_double import Pairs, of_exact
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import Flat, Real, Rows, Scalar, States, combination
from polhode.numbers.vectors import Vector, dot
from polhode.scenes import body as classification
from polhode.scenes.scene import Scene

GUARD_BITS = 64
NEAR_REST = 10  # where |G(0)| is so many times less than the pendulum's momentum
ENERGY, AREA, LENGTH = "h", "f", "|gamma|^2"
MOMENTUM, SPIN, KOVALEVSKAYA, CHAPLYGIN = "|G|^2", "spin", "K^2", "F"


#: The integrals at a state, and their relative departures from the start's.
IntegralFormula: TypeAlias = (
    "Callable[[Sequence[Scalar] | Flat, Mapping[str, Scalar], Scalar], "
    "tuple[list[Scalar], list[Scalar]]]"
)


class Drift(NamedTuple):
    """Largest departures of h, f, |gamma|² and the fourth integral over all output times.

    They are relative to T(0) + Mg|r0|, |G(0)|, 1, and for the fourth, with n the larger of |w(0)|
    and sqrt(Mg|r0|/largest moment): |G|² to |G(0)|², the spin to n, K² to (n² + |c|)², F to
    n (n² + |c|).
    From rest and near it |G(0)| says nothing about the motion: where it is less than a tenth of the
    momentum of the pendulum's rate, sqrt(Mg|r0|·largest moment), that one stands for it.  A zero
    scale that is left is replaced by 1.  f and gamma are None for a
    scene without gamma, the fourth where there is none, all of them where no state was reached.
    """

    h: float | None
    f: float | None
    gamma: float | None
    fourth: float | None = None

    def __str__(self) -> str:
        drifts = self._asdict().items()
        return ", ".join(
            f"{name} {_drift_text(value)}" for name, value in drifts if value is not None
        )


def _drift_text(drift: float) -> str:
    return f"over {sys.float_info.max:.1e}" if math.isinf(drift) else f"{drift:.3e}"


@dataclass(frozen=True)
class FirstIntegrals:
    """The first integrals of one scene, inside its frame.

    h is doubled, and inertia and torque are divided by the largest moment, so that values,
    coefficients and rates are of order 1.  ``onto``: their names.  ``order``: the principal axes
    with that of symmetry last.
    """

    onto: tuple[str, ...]
    order: tuple[int, int, int]
    coefficients: Mapping[str, Exact]

    def values(
        self, state: Sequence[Scalar], k: Mapping[str, Scalar], zero: Scalar
    ) -> list[Scalar]:
        """The integrals at one state, for any scalar: ``k`` the coefficients as such scalars."""
        omega, gamma = state[:3], state[3:6]
        momentum = [k[f"I{i}"] * omega[i] for i in range(3)]
        values = {ENERGY: dot(momentum, omega), MOMENTUM: dot(momentum, momentum)}
        if gamma:
            torque = combination(k, zero, *((f"2m{i}", gamma[i]) for i in range(3)))
            values |= {
                ENERGY: values[ENERGY] + torque,
                AREA: dot(momentum, gamma),
                LENGTH: dot(gamma, gamma),
            }
        if self.onto[-1] in _FOURTH:
            u = [omega[i] for i in self.order]
            g = [gamma[i] for i in self.order] if gamma else []
            values[self.onto[-1]] = _FOURTH[self.onto[-1]](u, g, k, zero)
        return [values[name] for name in self.onto]


def _spin(
    u: Sequence[Scalar], _: Sequence[Scalar], k: Mapping[str, Scalar], zero: Scalar
) -> Scalar:
    return combination(k, zero, *((f"n{i}", u[i]) for i in range(3)))


def _kovalevskaya(
    u: Sequence[Scalar], g: Sequence[Scalar], k: Mapping[str, Scalar], zero: Scalar
) -> Scalar:
    along = combination(k, zero, ("c0", g[0]), ("-c1", g[1]))
    across = combination(k, zero, ("c0", g[1]), ("c1", g[0]))
    real = u[0] * u[0] - u[1] * u[1] - along
    imaginary = u[0] * u[1] + u[0] * u[1] - across
    return real * real + imaginary * imaginary


def _chaplygin(
    u: Sequence[Scalar], g: Sequence[Scalar], k: Mapping[str, Scalar], zero: Scalar
) -> Scalar:
    along = combination(k, zero, ("c0", u[0]), ("c1", u[1]))
    return u[2] * (u[0] * u[0] + u[1] * u[1]) - along * g[2]


_FOURTH: dict[str, Callable[..., Scalar]] = {
    SPIN: _spin,
    KOVALEVSKAYA: _kovalevskaya,
    CHAPLYGIN: _chaplygin,
}


#: The fourth integral of a classical top; Goryachev and Chaplygin's where f = 0 alone.
_FOURTH_OF = {
    classification.EULER: MOMENTUM,
    classification.LAGRANGE: SPIN,
    classification.SPHERE: SPIN,
    classification.KOVALEVSKAYA: KOVALEVSKAYA,
    classification.CHAPLYGIN: CHAPLYGIN,
}


def first_integrals(scene: Scene) -> FirstIntegrals:
    """The first integrals that an exact scene has, one that is inside its frame."""
    body, torque = scene.body, scene.body.torque
    onto = [ENERGY] if scene.gamma is None else [ENERGY, AREA, LENGTH]
    name, order = _fourth(scene, torque)
    if name is not None:
        onto.append(name)
    k = coefficients(body.moments, torque, max(body.moments), onto[-1], order, exact.sqrt)
    nonzero = {key: x for key, x in k.items() if sign(x) != 0}
    return FirstIntegrals(tuple(onto), order, nonzero)


def coefficients(
    moments: Sequence[Scalar],
    torque: Sequence[Scalar],
    largest: Scalar,
    last: str,
    order: tuple[int, int, int],
    sqrt: Callable[[Scalar], Scalar],
) -> dict[str, Scalar]:
    """The coefficients of the integrals, for any scalars; ``last``: the last one's name."""
    k: dict[str, Scalar] = {f"I{i}": x / largest for i, x in enumerate(moments)}
    k |= {f"2m{i}": 2 * x / largest for i, x in enumerate(torque)}
    if last == SPIN:
        size = sqrt(dot(torque, torque))
        k |= {f"n{i}": torque[j] / size for i, j in enumerate(order)}
    elif last in (KOVALEVSKAYA, CHAPLYGIN):
        c0, c1 = (torque[i] / moments[order[2]] for i in order[:2])
        k |= {"c0": c0, "c1": c1, "-c1": -c1}
    return k


def _fourth(scene: Scene, torque: Vector) -> tuple[str | None, tuple[int, int, int]]:
    """The fourth integral's name, None without one, and the axes with that of symmetry last.

    ``torque``: Mg r0 in principal axes, in any unit.
    """
    top = classification.classical_top(scene.body.moments, torque)
    name = _FOURTH_OF.get(top.kind)
    if name == CHAPLYGIN:  # the area is asked for here alone: it takes as long as all the rest
        area = scene.integrals.area
        name = name if area is not None and sign(area) == 0 else None
    if name is None or top.axis is None or top.kind == classification.SPHERE:
        return name, (0, 1, 2)
    return name, classification.with_last(top.axis)


def exact_values(scene: Scene, integrals: FirstIntegrals) -> list[Exact]:
    """The values of its first integrals of an exact scene that is inside its frame."""
    return [exact.exact(x) for x in integrals.values(scene.start, integrals.coefficients, ZERO)]


def drift(scene: Scene, states: Rows, bits: int) -> Drift:
    """Drift of a trajectory's integrals, computed in more precision than the states have.

    ``states``: rows p q r [gamma1 gamma2 gamma3] in body axes, an ndarray of doubles or rows of mpf
    with ``bits`` significant bits.
    """
    departures_found = departures(scene, states, bits).values()
    with np.errstate(over="ignore"):  # told as inf
        return _named(scene, [float(np.max(np.abs(d.astype(float)))) for d in departures_found])


def departures(
    scene: Scene, states: States | Sequence[Sequence[Real]], bits: int = 53
) -> dict[str, States]:
    """Tell how far the first integrals depart from those of the start, along states of a motion.

    Parameters
    ----------
    scene : Scene
        Whose integrals; its start is exact.
    states : ndarray or rows
        p q r gamma1 gamma2 gamma3 in the scene's body axes, as a run has them.
    bits : int
        Of the numbers, where they are wider than double.

    Returns
    -------
    dict of ndarray
        The relative departures, with their signs, of each integral by its name: h, f, that of the
        length of gamma and, where there is one, the fourth.  A number a row: of long doubles for
        states in double, else of mpf.

    Raises
    ------
    ValueError
        A number that is not finite, of states wider than double.

    Examples
    --------
    >>> import polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2], project=False)
    >>> found = polhode.departures(run.scene, run.states)
    >>> sorted(found), float(abs(found["h"]).max()) < 1e-14
    (['f', 'h', 'spin', '|gamma|^2'], True)
    """
    names = first_integrals(Frame.of(scene).inside(scene)).onto
    if isinstance(states, np.ndarray) and states.dtype == np.float64:
        columns = list(states.astype(np.longdouble).T)
        columns_of = _departures(scene, [columns], to_extended)[0]
        ones = np.ones(len(states))  # an integral of nothing but zeros is one number
        return {name: d * ones for name, d in zip(names, columns_of, strict=True)}
    from polhode.numbers.mpmath_context import mpmath

    precision = bits + GUARD_BITS
    with mpmath.workprec(precision):
        wide = [[to_mpf(exactly(x), precision) for x in row] for row in states]
        rows = _departures(scene, wide, lambda x: to_mpf(x, precision))
    return dict(zip(names, np.array(rows, dtype=object).T, strict=True))


def drift_of_columns(scene: Scene, columns: Sequence[Pairs]) -> Drift | None:
    """The same of columns of pairs of doubles, all rows at once.

    None where a number on the way is beyond their range.
    """
    with np.errstate(all="ignore"):
        try:
            departures = _departures(scene, [columns], of_exact)[0]
        except OverflowError:
            return None
    largest = [float(np.max(np.abs(d.hi))) for d in departures]
    return _named(scene, largest) if all(map(math.isfinite, largest)) else None


def _named(scene: Scene, values: list[float]) -> Drift:
    """Values of h, f, |gamma|² and the fourth, as far as they are there, by name."""
    if scene.gamma is None:
        return Drift(values[0], None, None, *values[1:])
    return Drift(*values)


def _departures(
    scene: Scene, states: Iterable[Sequence[Scalar] | Flat], number: Callable[[Exact], Scalar]
) -> list[list[Scalar]]:
    """Relative departures of the integrals at each state (or at columns of states)."""
    formula, coefficients = along(scene)
    k = {name: number(x) for name, x in coefficients.items()}
    zero = number(ZERO)
    return [formula(state, k, zero)[1] for state in states]


def along(scene: Scene) -> tuple[IntegralFormula, Mapping[str, Exact]]:
    """A formula of states for the integrals there and their relative departures, for any scalars.

    Beside it its coefficients; its values are in the units of FirstIntegrals.
    """
    frame = Frame.of(scene)
    axes, inside = frame.axes, frame.inside(scene)
    integrals = first_integrals(inside)
    onto, turn = integrals.onto, range(0 if axes.trivial else 3)
    targets = [f"{name} at the start" for name in onto]
    relative_to = [f"scale of {name}" for name in onto]
    k, body = integrals.coefficients, inside.body
    scales = measures(integrals, k, body.moments, body.torque, inside.omega, _EXACTLY)
    coefficients: dict[str, Exact] = {
        **k,
        **dict(zip(targets, exact_values(inside, integrals), strict=True)),
        **dict(zip(relative_to, scales, strict=True)),
        **{f"axis {i}{j}": axes.rows[i][j] for i in turn for j in turn},
        "unit": frame.unit,
    }

    def formula(
        state: Sequence[Scalar] | Flat, k: Mapping[str, Scalar], zero: Scalar
    ) -> tuple[list[Scalar], list[Scalar]]:
        def principal(vector: Sequence[Scalar] | Flat) -> list[Scalar]:
            rows = [[k[f"axis {i}{j}"] for j in turn] for i in turn]
            return [dot(row, vector) for row in rows] or list(vector)

        inside = [k["unit"] * w for w in principal(state[:3])]
        inside += principal(state[3:]) if len(state) > 3 else []
        values = integrals.values(inside, k, zero)
        parts = zip(values, targets, relative_to, strict=True)
        return values, [(value - k[target]) / k[measure] for value, target, measure in parts]

    return formula, coefficients


class Choices(NamedTuple):
    """What measures take of numbers of one kind: exact ones, or numpy's arrays."""

    sqrt: Callable[[Scalar], Scalar]
    larger: Callable[[Scalar, Scalar], Scalar]
    where: Callable[[Scalar, Scalar, Scalar], Scalar]  # one of two by a condition


def measures(
    integrals: FirstIntegrals,
    k: Mapping[str, Scalar],
    moments: Sequence[Scalar],
    torque: Sequence[Scalar],
    omega: Sequence[Scalar],
    fn: Choices,
) -> list[Scalar]:
    """What each integral's departure is relative to, see Drift, in the units of FirstIntegrals.

    Of a body and a start inside the frame; ``k``: the integrals' coefficients.
    """
    largest = reduce(fn.larger, moments)
    unit = largest / largest
    momentum = [i * w for i, w in zip(moments, omega, strict=True)]
    weight, size = fn.sqrt(dot(torque, torque)), fn.sqrt(dot(momentum, momentum))
    swing = fn.sqrt(weight * largest)
    area = fn.where(NEAR_REST * size < swing, swing, size)
    energy = dot(momentum, omega) / 2 + weight
    energy, area = (fn.where(x == 0, unit, x) for x in (energy, area))
    scales = {ENERGY: 2 * energy / largest, AREA: area / largest, LENGTH: unit}
    name = integrals.onto[-1]
    if name == MOMENTUM:
        scales[name] = scales[AREA] * scales[AREA]
    elif name not in scales:
        rate = fn.sqrt(fn.larger(dot(omega, omega), weight / largest))
        c0, c1 = k.get("c0", 0), k.get("c1", 0)
        around = rate * rate + fn.sqrt(c0 * c0 + c1 * c1)
        scales[name] = {SPIN: rate, KOVALEVSKAYA: around * around}.get(name, rate * around)
    return [scales[name] for name in integrals.onto]


_EXACTLY = Choices(exact.sqrt, max, lambda which, x, y: x if which else y)
