"""How well the two hodographs of a run roll on each other (3.34)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput
from polhode.equations.kinematics import turned
from polhode.numbers.conversion import mpf_row, to_mpf
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.row_formulas import GUARD_BITS
from polhode.numbers.vectors import cross, dot, minus
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.body import Body
from polhode.scenes.vocabulary import REQUESTS

HALF_WINDOW = 12  # samples to either side from which the tangent of a curve is taken


class Rolling(NamedTuple):
    """How far the hodographs of a run are from rolling on each other: two relative errors.

    ``tangent``: the difference of the space curve's tangent and R w', over the largest |w'|, R the
    rotation from body to space; ``arc``: that of the two curves' lengths.

    >>> import polhode
    >>> polhode.Rolling(tangent=1e-15, arc=2e-16).arc
    2e-16
    """

    tangent: float
    arc: float


def omega_rate(body: Body, omega: Sequence[Any], gamma: Sequence[Any], bits: int) -> list[Any]:
    """w' = I⁻¹ (gamma × Mg r0 - w × I w) in scene axes, to so many bits (3.16).

    Written in vectors, apart from the forms that are integrated.
    """
    with mpmath.workprec(bits):
        x, y, z = ([to_mpf(entry, bits) for entry in row] for row in body.inertia)
        torque = [to_mpf(entry, bits) for entry in body.torque]
        momentum = [dot(row, omega) for row in (x, y, z)]
        moment = minus(cross(gamma, torque), cross(omega, momentum))
        adjugate = cross(y, z), cross(z, x), cross(x, y)
        determinant: Any = dot(x, adjugate[0])
        return [dot(row, moment) / determinant for row in adjugate]


def rolling(run: Trajectory) -> Rolling:
    """Measure how well a run keeps the rolling condition of its hodographs.

    The tangent of the space curve is computed from its own points, by differences over
    ``2·HALF_WINDOW + 1`` samples around each; that of the body's curve from the equations, rotated
    by the attitude.  A wrong attitude, or a slip of one curve on the other, makes them differ.

    Parameters
    ----------
    run : Trajectory
        A run of a scene with gamma and the output "hodographs".  Samples must be dense: the error
        of the differences falls with the 24th power of their spacing, that of rounding grows with
        its inverse.

    Returns
    -------
    Rolling
        The largest relative deviation of the tangents and of the lengths.

    Raises
    ------
    BadInput
        A run without hodographs, or with fewer samples than the window holds.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import polhode
    >>> scene = replace(polhode.load("lagrange/nutation"), outputs=("hodographs",))
    >>> run = polhode.integrate(scene, "quad", at=[f"{k}/100" for k in range(101)])
    >>> 1e-33 < polhode.rolling(run).tangent < 1e-30
    True
    """
    of_kind("rolling", "run", run, Trajectory, "a Trajectory")
    library.load(run.scene, takes=REQUESTS)
    curves, width = run.hodographs, 2 * HALF_WINDOW + 1
    attitude = run.attitude
    if curves is None or attitude is None or len(run.times) < width:
        needed = f"a run with hodographs at {width} times or more"
        raise BadInput(run.scene.name, "run.outputs", None, needed)
    bits = run.number.bits + GUARD_BITS
    worst = fastest = body_arc = space_arc = mpmath.mpf(0)
    before: Any = None
    with mpmath.workprec(bits):
        times = [to_mpf(t, bits) for t in run.times]
        space = [mpf_row(row, bits) for row in curves.space]
        for k in range(HALF_WINDOW, len(times) - HALF_WINDOW):
            window = slice(k - HALF_WINDOW, k + HALF_WINDOW + 1)
            weights = _derivative_weights(times[window])
            slope = [mpmath.fdot(weights, column) for column in zip(*space[window], strict=True)]
            state = mpf_row(run.states[k], bits)
            rate = omega_rate(run.scene.body, state[:3], state[3:], bits)
            expected = turned(mpf_row(attitude[k], bits), rate)
            worst = max(worst, _length([a - b for a, b in zip(slope, expected, strict=True)]))
            speeds = _length(rate), _length(slope)
            fastest = max(fastest, speeds[0])
            if before is not None:  # the same trapezia for both: only the curves differ
                span = abs(times[k] - times[k - 1]) / 2
                body_arc += span * (speeds[0] + before[0])
                space_arc += span * (speeds[1] + before[1])
            before = speeds
        return Rolling(_relative(worst, fastest), _relative(abs(space_arc - body_arc), body_arc))


def _derivative_weights(nodes: Sequence[Any]) -> list[Any]:
    """Weights of the derivative at the middle node of the polynomial through all of them (mpf)."""
    middle = len(nodes) // 2
    scale = [
        1 / mpmath.fprod(x - y for j, y in enumerate(nodes) if j != i) for i, x in enumerate(nodes)
    ]
    weights = [
        mpmath.mpf(0) if i == middle else scale[i] / scale[middle] / (nodes[middle] - x)
        for i, x in enumerate(nodes)
    ]
    weights[middle] = -mpmath.fsum(weights)
    return weights


def _length(vector: Sequence[Any]) -> Any:
    return mpmath.sqrt(mpmath.fsum(x * x for x in vector))


def _relative(size: Any, whole: Any) -> float:
    return float(size / whole) if whole else float(size)
