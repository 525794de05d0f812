"""The search for a certificate of a periodic orbit: an approximate one, its digits, box and grid.

Not trusted, as nothing of a certificate is but the body's and the level's numbers: what
``certificates/verify.py`` proves of it holds.  Krawczyk's test on a box of radius r knows the orbit
to about r^2, or to r times the error of the flow's derivative, if that is more: so a centre that is
right to half of the digits wanted is enough, or to a few less than these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.dynamics import newton_shooting
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.newton_shooting import Closed, NotClosed
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign
from polhode.numbers.flint_context import ctx
from polhode.proofs.theorem import NotProved
from polhode.scenes.scene import Scene

# --- certificate --------------------------------------------------------------------------------


_DIVISORS = 2  # times as many as the steepness at the start asks: primes to divide the period by


def guesses(
    on: LevelBody,
    start: Sequence[Fraction],
    period: Fraction,
    radius: Fraction,
    bits: int,
    part: float,
) -> JsonObject:
    """A certificate but for its statement.

    ``start``, ``period``: x* and T*, near an orbit, in the scene's axes and units.  ``radius``: of
    the box around them, states being about 1; ``part``: of the radius of convergence, a step.
    """
    state_bits = bits + 8  # the first centre is x* itself
    scene = certificate_file.on_level(on.scene.body, on.h, on.f, bits + verify.COARSE)
    with ctx.workprec(bits + 2 * verify.COARSE):
        x = [verify.ball((x, Fraction(0))) for x in start]
        steps = certificate_file.steps(scene, x, period, bits, bits, part)
        centres = [[x << state_bits - steps.state_bits for x in row] for row in steps.centres]
        centres[0] = [round(x * (1 << state_bits)) for x in start]
        steps = steps._replace(state_bits=state_bits, centres=centres)
        run = verify.Run(steps, *verify.balls_of(verify.read_body(scene, ("level",)))[:2])
        steep = max(float(verify.steepness(verify.slope(run.body, x)).mid()) for x in run.centres)
    steep *= float(period * Fraction(2) ** run.shift)
    *grid, _ = steps._asdict().items()
    return {
        "format": verify.FORMAT,
        "kind": "orbit",
        "scene": scene,
        **dict(grid),
        "radius_bits": math.floor(-math.log2(radius)),
        "divided_to": math.ceil(_DIVISORS * steep / (2 * math.pi)),
        "bits": bits,
    }


# --- search ---------------------------------------------------------------------------------------


BITS_A_DIGIT = math.log2(10)
_SPARE = 40  # bits beyond the digits wanted
_CENTRE = 9  # digits of the centre beyond half of those wanted
_FEWER = 7  # or so many less
_BOX = 3  # digits by which the box is wider than the centre's error
_TRIES = 5
_STEPS = (0.25, 0.15, 0.1)  # of the radius of convergence
_SINGULAR = 1e11  # condition of the ten equations


def closed_near(on: LevelBody, near: Scene) -> Closed:
    """The orbit near a scene's start whose period is about its end; raises BadInput, NotProved."""
    if near.gamma is None or near.end is None or sign(near.end) <= 0:
        raise BadInput(near.name, "orbit", None, "a start with gamma, and run.end, its period")
    inside = on.scene.body.axes.components
    scaled = tuple(on.unit * w for w in inside(near.omega))
    state = np.array([to_double(x) for x in (*scaled, *inside(near.gamma))])
    try:
        return newton_shooting.closed(on, state, to_double(near.end / on.unit))
    except NotClosed as why:
        line = f"no periodic orbit is near the start ({why}); try another start"
        raise NotProved(f"{on.scene.name}: {line}") from None


def proof_of(
    on: LevelBody, orbit: Closed, digits: int, progress: Message | None = None
) -> tuple[verify.Zero, JsonObject, float, int]:
    """The first certificate with so many digits that the checker proves; raises NotProved.

    What the checker proved, of which guesses, its digits, and how often the checker was called.
    """
    place = max(digits // 2 + _CENTRE, digits - _FEWER)
    bits = math.ceil(BITS_A_DIGIT * digits) + _SPARE
    why, proved_digits = "", 0.0
    for tried in range(_TRIES):
        if progress is not None:
            progress(f"certificate {tried + 1}, {bits} bits")
        try:
            fine = newton_shooting.refined(on, orbit, place)
        except NotClosed as fault:
            why = str(fault)
            break
        start = [Fraction(x) for x in (*fine.omega, *fine.gamma)]
        radius, part = Fraction(1, 10 ** (place - _BOX)), _STEPS[min(tried, len(_STEPS) - 1)]
        certificate = guesses(on, start, Fraction(fine.period), radius, bits, part)
        try:
            zero = by_checker(verify.zero_near, certificate)
        except verify.NotProved as refused:
            why = str(refused)
            if _condition(on, orbit) > _SINGULAR:
                break
            place, bits = place + 8, bits + 48
            continue
        except verify.Damaged as fault:  # of too many steps
            line = f"{fault}; try fewer digits, or a shorter orbit"
            raise NotProved(f"{on.scene.name}: {line}") from None
        proved_digits, why = _digits_of(on, orbit, zero), zero.repeated
        if proved_digits >= digits or why:
            break
        more = math.ceil(digits - proved_digits) + 1
        place, bits = place + more // 2 + 1, bits + math.ceil(BITS_A_DIGIT * more)
    if why or proved_digits < digits:
        why = why or f"{proved_digits:.1f} digits are proved, not {digits}"
        raise NotProved(f"{on.scene.name}: {_advice(on, orbit, why)}")
    return zero, certificate, proved_digits, tried + 1


def _digits_of(on: LevelBody, orbit: Closed, zero: verify.Zero) -> float:
    """Proven digits of start and period: the state's in parts of its scale."""
    scales = [*(on.scale(orbit.state) / [*[float(on.unit)] * 3, 1.0, 1.0, 1.0]).tolist()]
    worst = max(float(x.rad()) / scale for x, scale in zip(zero.start, scales, strict=True))
    worst = max(worst, float(zero.period.rad()) / float(zero.period.mid()))
    return -math.log10(worst) if worst else math.inf


def _condition(on: LevelBody, orbit: Closed) -> float:
    """Of the ten equations, in double."""
    sizes = np.linalg.svd(newton_shooting.matrix_of(on, orbit, orbit.state))[1]
    return float(sizes[0] / sizes[-1]) if sizes[-1] else math.inf


def _advice(on: LevelBody, orbit: Closed, why: str) -> str:
    """What the checker refused, and what may be done about it."""
    condition = _condition(on, orbit)
    if condition > _SINGULAR:
        return (
            f"the orbit is not isolated, or nearly so: {why}; the ten equations have the condition "
            f"{condition:.1g}, a further multiplier is about 1; try another level"
        )
    times, _, rest = why.removeprefix("the period may be ").partition(" times the least one")
    if not rest and times.isdigit():
        shorter = orbit.period * float(on.unit) / int(times)
        return f"{why}; try the period {shorter:.10g}"
    return f"{why}; try more digits, or another orbit"
