"""A certificate of an enclosure: its statement, and guesses that an independent program needs."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias

from flint import arb

from polhode.certificates import verify
from polhode.common.errors import BadInput
from polhode.common.files import check_writable, write_whole
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.flint_context import ctx
from polhode.scenes.scene import Scene

#: Middle and radius as decimals.
Ball: TypeAlias = tuple[str, str]

_STEP = 0.3  # of the radius of convergence
_ORDER = 24  # of the polynomials that tell it
_LONGEST = 1.0  # step, in the unit of time that the body suggests
_SPARE, _MORE, _TRIES = 28, 16, 5  # bits beyond the smallest radius, and further ones
_SHARPEST = 2.0**-20  # a radius is no smaller a part of the largest at its time


def save(
    scene: Scene, times: Sequence[Exact], balls: Sequence[Sequence[Ball]], path: str | Path
) -> None:
    """Write the certificate that a scene's states lie in balls at certain times.

    It is checked before it is written, with more bits where that does not succeed at once.  Raises
    BadInput for what has no certificate, or cannot be written.
    """
    check_writable(Path(path), [".json"], [])
    write_whole({Path(path): json.dumps(certificate(scene, times, balls)) + "\n"})


def certificate(
    scene: Scene, times: Sequence[Exact], balls: Sequence[Sequence[Ball]]
) -> dict[str, object]:
    """The certificate as JSON's objects, checked; raises BadInput."""
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "given, for a certificate")
    claimed: list[tuple[Fraction, Sequence[Ball]]] = []
    for t, row in zip(times, balls, strict=True):
        if not isinstance(t, Fraction):
            raise BadInput(scene.name, "at", shown(t), "rational times, for a certificate")
        if t != 0:  # where the scene itself says it
            claimed.append((t, _widened(row)))
    if not claimed or min(claimed)[0] < 0 < max(claimed)[0]:
        raise BadInput(scene.name, "at", None, "times of one sign, for a certificate")
    statement = [{"t": str(t), "balls": [list(ball) for ball in row]} for t, row in claimed]
    last = max((t for t, _ in claimed), key=abs)
    least = min(float(radius) for _, row in claimed for _, radius in row)
    bits = max(verify.COARSE, math.ceil(-math.log2(least))) + _SPARE
    fault = ""
    for _ in range(_TRIES):
        body = _scene(scene, bits + verify.COARSE)
        with ctx.workprec(bits + 2 * verify.COARSE):
            guesses = _guesses(body, last, bits)
        found: dict[str, object] = {
            "format": verify.FORMAT,
            "kind": "state",
            "scene": body,
            **guesses,
            "bits": bits,
            "statement": statement,
        }
        try:
            with ctx.workprec(bits):  # which the checker changes as it likes
                verify.state(found)
        except verify.NotProved as refused:
            fault, bits = str(refused), bits + _MORE
            continue
        return found
    raise BadInput(scene.name, "certificate", fault, "a statement that its own checker proves")


def _widened(row: Sequence[Ball]) -> list[Ball]:
    """Balls of one time of which none is far smaller than the others: they cost bits."""
    least = max(float(radius) for _, radius in row) * _SHARPEST
    return [
        (middle, radius if float(radius) >= least else f"{least:.2e}") for middle, radius in row
    ]


def _scene(scene: Scene, bits: int) -> dict[str, object]:
    """The scene's exact numbers as texts, irrational ones as balls."""
    body = scene.body
    rows = [[_number(x, bits) for x in row] for row in body.inertia]
    turned = any(body.inertia[i][j] != 0 for i in range(3) for j in range(3) if i != j)
    assert scene.gamma is not None
    return {
        **({"inertia": rows} if turned else {"moments": [rows[i][i] for i in range(3)]}),
        "centre": [_number(x, bits) for x in body.centre],
        "weight": _number(body.weight, bits),
        "omega": [_number(x, bits) for x in scene.omega],
        "gamma": [_number(x, bits) for x in scene.gamma],
    }


def _number(x: Exact, bits: int) -> str | list[str]:
    if not isinstance(x, Irrational):
        return str(x)
    mantissa, exponent = exact.rounded(x, bits)
    unit = Fraction(2) ** exponent  # more than the rounding
    return [str(mantissa * unit), str(unit)]


def _guesses(scene: dict[str, object], end: Fraction, bits: int) -> dict[str, object]:
    """A grid of steps to ``end``, and numbers near the motion at its times."""
    inertia, torque, start = verify.balls_of(verify.read_scene(scene))
    shift = verify.scaling(inertia, torque, start)
    body = verify.Body(inertia, [x * arb(2) ** (-2 * shift) for x in torque])
    fine, sense = 12, 1 if end > 0 else -1
    last = math.ceil(abs(end) * Fraction(2) ** (fine + shift))
    state_bits = bits // 2 + 30
    powers = [state_bits + shift] * 3 + [state_bits] * 3
    x = [(x * arb(2) ** (-shift if k < 3 else 0)).mid() for k, x in enumerate(start)]
    grid, centres = [0], []
    while abs(grid[-1]) < last:
        centres.append([_nearest(y * arb(2) ** e) for y, e in zip(x, powers, strict=True)])
        steps = max(1, min(int(_length(body, x) * 2**fine), last - abs(grid[-1])))
        h = arb(sense * steps) * arb(2) ** -fine
        x = [verify.summed(row).mid() for row in verify.taylor(body, x, h, bits)]
        grid.append(grid[-1] + sense * steps)
    return {
        "time_bits": fine + shift,
        "grid": grid,
        "state_bits": state_bits,
        "centres": centres,
    }


def _nearest(x: arb) -> int:
    found = (x.mid() + arb("0.5")).floor().mid().unique_fmpz()
    assert found is not None
    return int(found)


def _length(body: verify.Body, centre: Sequence[arb]) -> float:
    """A step that is a part of the radius of convergence."""
    rows = verify.taylor(body, centre, arb(1), _ORDER)
    sizes = [max(float(abs(row[k])) for row in rows) for k in range(len(rows[0]))]
    rates = [x ** (1 / k) for k, x in enumerate(sizes) if 3 * k > _ORDER and x > 0]
    return min(_STEP / max(rates, default=_STEP), _LONGEST)
