"""A certificate of a proved periodic orbit: its statement, and guesses that its checker needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from polhode.certificates import grid, verify
from polhode.certificates.certificate_file import Made, checked, write
from polhode.certificates.state_certificate import Ball
from polhode.common.files import check_writable
from polhode.common.progress import Progress
from polhode.numbers.exact import ONE, Exact
from polhode.numbers.flint_context import ctx
from polhode.scenes.body import Body

_SPARE = 40  # bits beyond the smallest radius
_WIDER = 8  # the box, beside how far the orbit is alone
_NEARER = 4  # and how much less of that is stated where this does not succeed
_STEPS = (0.3, 0.15, 0.1, 0.1, 0.1)  # of the radius of convergence: large boxes ask for short ones
_DIVISORS = 2  # times as many as the steepness at the start asks: primes to divide the period by


class Stated(NamedTuple):
    """What is to be proved of an orbit; ``alone``: in omega, gamma and the period."""

    h: Exact
    f: Exact
    kind: str
    start: Sequence[Ball]
    period: Ball
    residue: Ball
    alone: Sequence[str | Fraction]


def save(
    name: str, body: Body, stated: Stated, path: str | Path, progress: Progress | None = None
) -> None:
    """Write the certificate of a periodic orbit of a body, checked before.

    ``name``: of the scene.  How far the orbit is alone is stated in full if the checker proves it,
    else less of it.  Raises BadInput for what cannot be proved so, or cannot be written.
    """
    check_writable(Path(path), [".json"], [])
    write(path, certificate(name, body, stated, progress))


def certificate(name: str, body: Body, stated: Stated, progress: Progress | None = None) -> Made:
    """The certificate as JSON's objects, checked; raises BadInput."""
    least = min(float(radius) for _, radius in (*stated.start, stated.period))
    statement = {
        "kind": stated.kind,
        "start": [list(ball) for ball in stated.start],
        "period": list(stated.period),
        "residue": list(stated.residue),
        "least": True,
    }

    def made(bits: int, tried: int) -> Made:
        alone = [Fraction(x) / _NEARER ** max(0, tried - 1) for x in stated.alone]
        numbers = grid.body_numbers(body, bits + verify.COARSE)
        level = [grid.number(x, bits + verify.COARSE) for x in (stated.h, stated.f, ONE)]
        with ctx.workprec(bits + 2 * verify.COARSE):
            guesses = _guesses(numbers, stated._replace(alone=alone), bits, _STEPS[tried], progress)
        return {
            "format": verify.FORMAT,
            "kind": "orbit",
            "scene": {**numbers, "level": level},
            **guesses,
            "bits": bits,
            "statement": {**statement, "alone": [str(x) for x in alone]},
        }

    bits = max(verify.COARSE, math.ceil(-math.log2(least))) + _SPARE
    return checked(name, made, bits, progress)


def _guesses(
    numbers: dict[str, object],
    stated: Stated,
    bits: int,
    part: float,
    progress: Progress | None,
) -> Made:
    """Steps of one period, the box's radius, and by how much the period is divided."""
    start = [Fraction(middle) for middle, _ in stated.start]
    period = Fraction(stated.period[0])
    x = [verify.ball((x, Fraction(0))) for x in start]
    found = grid.steps(numbers, x, period, bits, bits, part, progress)
    state_bits = bits + 8  # the first centre is x* itself
    centres = found["centres"]
    assert isinstance(centres, list)
    more = state_bits - int(str(found["state_bits"]))
    centres = [[x << more for x in row] for row in centres]
    centres[0] = [round(x * (1 << state_bits)) for x in start]
    rows, (centre, (weight,)), _ = verify.read_body(numbers, ())
    inertia = [[verify.ball(x) for x in row] for row in rows]
    torque = [verify.ball(weight) * verify.ball(x) for x in centre]
    held = {**found, "state_bits": state_bits, "centres": centres, "bits": bits}
    guesses = verify.read_guesses([held[name] for name in verify.Guesses._fields])
    run = verify.Run(guesses, inertia, torque)
    steep = max(
        float(verify.steepness(verify.slope(run.body, x)).mid()) for x in run.centres
    ) * float(period * Fraction(2) ** run.shift)
    omega, gamma, beside = (Fraction(x) for x in stated.alone)
    unit = Fraction(2) ** run.shift
    least = max(Fraction(radius) for _, radius in (*stated.start, stated.period))
    radius = _WIDER * max(omega / unit, gamma, beside * unit / 4, least)
    return {
        **found,
        "state_bits": state_bits,
        "centres": centres,
        "radius_bits": math.floor(-math.log2(radius)),
        "divided_to": math.ceil(_DIVISORS * steep / (2 * math.pi)),
    }
