"""Hodographs of omega in the body and in space, and what else rolls and turns (3.34).

The body's motion is the rolling, without slipping, of the cone that omega describes in the body
upon the one that it describes in space: as w × w = 0,

    d(R w)/dt = R (w' + w × w) = R w'

so the two curves have a common tangent and equal arcs.  For a free body they are the polhode and
the herpolhode.  R (body -> space, z up) is that of the attitude quaternion, of whatever length:
R(q) v = q ⊗ (0, v) ⊗ q* / |q|², an exact rotation though |q| drifts by rounding.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.body import Body, cross, dot, minus
from polhode.differences import derivative_weights
from polhode.exact import Exact
from polhode.precision import NumberType, exactly, extended_here, to_extended, to_mpf

if TYPE_CHECKING:
    from polhode.trajectory import Trajectory

GUARD_BITS = 64
HALF_WINDOW = 12  # samples to either side from which the tangent of a curve is taken


class Hodographs(NamedTuple):
    """Rows of omega along the body's axes and along those of space (z up), a row a time.

    Arrays for double and extended, rows of mpf above; ``space`` is formed in more precision than
    the numbers have and rounded once.
    """

    body: Any
    space: Any


class Rolling(NamedTuple):
    """How far the hodographs of a run are from rolling on each other, relative mismatches.

    ``tangent``: of the space curve's tangent against R w', over the largest |w'|; ``arc``: of the
    two curves' lengths.
    """

    tangent: float
    arc: float


def hodographs(states: Any, attitude: Any, number: NumberType) -> Hodographs:
    """The hodographs of a motion: rows p q r … and q0 q1 q2 q3 of one number type."""
    omega = states[:, :3] if hasattr(states, "ndim") else [row[:3] for row in states]
    return Hodographs(omega, in_space(attitude, omega, number))


def in_space(attitude: Any, vectors: Any, number: NumberType) -> Any:
    """R v for each row of the attitude and of vectors in the body, in the number type."""
    if number.name == "double" and extended_here():
        import numpy as np

        quaternion, vector = (np.asarray(x, dtype=np.longdouble).T for x in (attitude, vectors))
        return np.array(turned(quaternion, vector)).T.astype(np.float64)
    import mpmath

    wide = number.bits + GUARD_BITS
    with mpmath.workprec(wide):
        rows = [
            turned(_mpf(q, wide), _mpf(v, wide)) for q, v in zip(attitude, vectors, strict=True)
        ]
    if number.name in ("double", "extended"):
        import numpy as np

        kind, to = (np.float64, float) if number.name == "double" else (np.longdouble, to_extended)
        return np.array([[to(exactly(x)) for x in row] for row in rows], dtype=kind)
    with mpmath.workprec(number.bits):
        return [[+x for x in row] for row in rows]


def turned(quaternion: Any, vector: Any) -> list[Any]:
    """R(q) v of one quaternion of any length, or of columns of them."""
    q0, axis = quaternion[0], (quaternion[1], quaternion[2], quaternion[3])
    square = q0 * q0 + dot(axis, axis)
    half: Any = cross(axis, (vector[0], vector[1], vector[2]))
    across = cross(axis, half)
    return [v + 2 * (q0 * a + b) / square for v, a, b in zip(vector, half, across, strict=True)]


def path(attitude: Any, direction: Iterable[Exact], number: NumberType) -> Any:
    """The path in space of a point fixed in the body: R e for each row of the attitude.

    ``direction``: e in the body, such as the third axis (0, 0, 1), the apex of a top, or the
    direction of the centre of mass.
    """
    e = [to_mpf(x, number.bits + GUARD_BITS) for x in direction]
    if number.name == "double" and extended_here():
        e = [to_extended(exactly(x)) for x in e]
    return in_space(attitude, [e] * len(attitude), number)


def omega_rate(body: Body, omega: Sequence[Any], gamma: Sequence[Any], bits: int) -> list[Any]:
    """w' = I⁻¹ (gamma × Mg r0 - w × I w) in scene axes, to so many bits (3.16).

    Written in vectors, apart from the forms that are integrated.
    """
    import mpmath

    with mpmath.workprec(bits):
        x, y, z = ([to_mpf(entry, bits) for entry in row] for row in body.inertia)
        torque = [to_mpf(entry, bits) for entry in body.torque]
        momentum = [dot(row, omega) for row in (x, y, z)]  # type: ignore[arg-type]
        moment = minus(cross(gamma, torque), cross(omega, momentum))  # type: ignore[arg-type]
        adjugate = cross(y, z), cross(z, x), cross(x, y)  # type: ignore[arg-type]
        determinant: Any = dot(x, adjugate[0])  # type: ignore[arg-type]
        return [dot(row, moment) / determinant for row in adjugate]


def rolling(run: Trajectory) -> Rolling:
    """How well a run with hodographs (and gamma) keeps the rolling condition, measured.

    The tangent of the space curve is taken from its own points, by differences over
    ``2·HALF_WINDOW + 1`` samples around each; that of the body's curve from the equations, and
    turned by the attitude: a wrong attitude, a slip of one curve on the other, shows at once.
    Samples must be dense: what the differences leave falls like the 24th power of their
    distance, what rounding leaves grows like its inverse.  Raises ValueError where
    there are no hodographs or fewer samples than the window holds.
    """
    import mpmath

    curves, width = run.hodographs, 2 * HALF_WINDOW + 1
    if curves is None or len(run.times) < width:
        raise ValueError(f"the rolling condition needs hodographs at {width} times or more")
    bits = run.number.bits + GUARD_BITS
    worst = fastest = body_arc = space_arc = mpmath.mpf(0)
    before: Any = None
    with mpmath.workprec(bits):
        times = [to_mpf(t, bits) for t in run.times]
        space = [_mpf(row, bits) for row in curves.space]
        for k in range(HALF_WINDOW, len(times) - HALF_WINDOW):
            window = slice(k - HALF_WINDOW, k + HALF_WINDOW + 1)
            weights = derivative_weights(times[window])
            slope = [mpmath.fdot(weights, column) for column in zip(*space[window], strict=True)]
            state = _mpf(run.states[k], bits)
            rate = omega_rate(run.scene.body, state[:3], state[3:], bits)
            expected = turned(_mpf(run.attitude[k], bits), rate)
            worst = max(worst, _length([a - b for a, b in zip(slope, expected, strict=True)]))
            speeds = _length(rate), _length(slope)
            fastest = max(fastest, speeds[0])
            if before is not None:  # the same trapezia for both: only the curves differ
                span = abs(times[k] - times[k - 1]) / 2
                body_arc += span * (speeds[0] + before[0])
                space_arc += span * (speeds[1] + before[1])
            before = speeds
        return Rolling(_relative(worst, fastest), _relative(abs(space_arc - body_arc), body_arc))


def _mpf(row: Sequence[Any], bits: int) -> list[Any]:
    return [to_mpf(exactly(x), bits) for x in row]


def _length(vector: Sequence[Any]) -> Any:
    import mpmath

    return mpmath.sqrt(mpmath.fsum(x * x for x in vector))


def _relative(size: Any, whole: Any) -> float:
    return float(size / whole) if whole else float(size)
