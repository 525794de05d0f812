"""The search for a certificate of a periodic orbit: an approximate one, its digits, box and grid.

Not trusted, as nothing of a certificate is: what ``certificates/verify.py`` proves of it holds.
Krawczyk's test on a box of radius r knows the orbit to about r^2, or to r times the error of
the flow's derivative, if that is more: so a centre that is right to half of the digits wanted
is enough, or to a few less than these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.certificates import orbit_certificate, verify
from polhode.certificates.certificate_file import Made
from polhode.certificates.orbit_certificate import Choice, Problem
from polhode.common.interrupts import Message
from polhode.dynamics import newton_shooting
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.newton_shooting import Closed, NotClosed, at_level, bordered, closed
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.polynomials import middle
from polhode.proofs.refusals import NotProved
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

# --- certified orbit ------------------------------------------------------------------------------


# --- refusals -------------------------------------------------------------------------------------
#
# The search for a certificate of a periodic orbit: an approximate one, its digits, box, grid.


BITS_A_DIGIT = math.log2(10)
_SPARE = 40  # bits beyond the digits wanted
_CENTRE = 9  # digits of the centre beyond half of those wanted
_FEWER = 7  # or so many less
_BOX = 3  # digits by which the box is wider than the centre's error
_TRIES = 5
_STEPS = (0.25, 0.15, 0.1)  # of the radius of convergence
_SINGULAR = 1e11  # condition of the ten equations
_ROUGH = Choice(Fraction(1, 1 << 40), 96, 0.25)  # of a guess that Newton's method cannot better
_BINARY = 200  # bits of such a guess

_FINER = 40  # bits beyond a tolerance
_BOXES = range(4, 22, 2)  # bits by which a box of many bodies' orbits is wider than the tolerance
_TOO_WIDE = "the condition of the step"  # which fails for a larger box, too
_SHORT = 0.05  # steps, of these
_NARROWEST = 16  # decimals of the last tolerance that is looked at


class Candidate(NamedTuple):
    """An approximate orbit; ``closed``: in double, or the reason why there is none."""

    on: LevelBody
    name: str
    closed: Closed | str
    start: tuple[Fraction, ...]
    period: Fraction


class OrbitProof(NamedTuple):
    """What the checker proved, of which guesses; ``runs``: how often it was called.

    Of bodies within a tolerance in their principal axes, else in the scene's.
    """

    zero: verify.Zero
    made: Made
    digits: float
    runs: int


def of_closed(on: LevelBody, orbit: Closed) -> Candidate:
    """The candidate that a search in double gives."""
    return Candidate(on, on.scene.name, orbit, (), Fraction(0))


def of_scene(on: LevelBody, near: Scene) -> Candidate:
    """The candidate near a scene's start whose period is about the scene's time."""
    assert near.gamma is not None
    assert near.end is not None
    exact_start = (*near.omega, *near.gamma)
    start = [exact.binary(*exact.rounded(x, _BINARY)) if x else Fraction(0) for x in exact_start]
    period = exact.binary(*exact.rounded(near.end, _BINARY))
    inside = on.scene.body.axes.components
    scaled = tuple(on.unit * w for w in inside(near.omega))
    state = np.array([to_double(x) for x in (*scaled, *inside(near.gamma))])
    orbit: Closed | str
    try:
        orbit = closed(on, state, to_double(period / on.unit), at_level(on, state))
    except NotClosed as why:
        orbit = str(why)
    return Candidate(on, on.scene.name, orbit, tuple(start), period)


def certified(
    candidate: Candidate,
    digits: int,
    progress: Message | None = None,
    tolerance: Fraction | None = None,
) -> OrbitProof:
    """The first certificate with so many digits that the checker proves; raises NotProved."""
    proof = _certified(candidate, digits, progress)
    return _of_bodies(candidate, proof, tolerance) if tolerance else proof


def _certified(candidate: Candidate, digits: int, progress: Message | None) -> OrbitProof:
    place = max(digits // 2 + _CENTRE, digits - _FEWER)
    bits = math.ceil(BITS_A_DIGIT * digits) + _SPARE
    why, have = "", 0.0
    for tried in range(_TRIES):
        if progress is not None:
            progress(f"certificate {tried + 1}, {bits} bits")
        part = _STEPS[min(tried, len(_STEPS) - 1)]
        problem, choice = _chosen(candidate, place, Choice(Fraction(1), bits, part))
        certificate = orbit_certificate.guesses(problem, choice)
        try:
            zero = orbit_certificate.proved(certificate)
        except verify.NotProved as refused:
            why = str(refused)
            if isinstance(candidate.closed, str) or _condition(candidate) > _SINGULAR:
                break
            place, bits = place + 8, bits + 48
            continue
        have, why = _digits_of(candidate, zero), zero.repeated
        if have >= digits or why:
            break
        more = math.ceil(digits - have) + 1
        place, bits = place + more // 2 + 1, bits + math.ceil(BITS_A_DIGIT * more)
    if why or have < digits:
        why = why or f"{have:.1f} digits are proved, not {digits}"
        raise NotProved(f"{candidate.name}: {_refusal(candidate, why)}")
    return OrbitProof(zero, certificate, have, tried + 1)


def _chosen(candidate: Candidate, place: int, choice: Choice) -> tuple[Problem, Choice]:
    """The problem with a centre that is right to so many digits, and its box."""
    on = candidate.on
    if isinstance(candidate.closed, str):
        return Problem(on.scene.body, on.h, on.f, candidate.start, candidate.period), _ROUGH
    orbit = candidate.closed
    try:
        fine = newton_shooting.refined(on, orbit, [exactly(x) for x in orbit.state.tolist()], place)
    except NotClosed as fault:
        raise NotProved(f"{candidate.name}: {_refusal(candidate, str(fault))}") from None
    start = [Fraction(x) for x in (*fine.omega, *fine.gamma)]
    radius = Fraction(1, 10 ** (place - _BOX))
    problem = Problem(on.scene.body, on.h, on.f, start, Fraction(fine.period))
    return problem, choice._replace(radius=radius)


def _digits_of(candidate: Candidate, zero: verify.Zero) -> float:
    """Proven digits of start and period: the state's in parts of its scale."""
    on, guess = candidate.on, candidate.closed
    assert not isinstance(guess, str)
    scales = [*(on.scale(guess.state) / [*[float(on.unit)] * 3, 1.0, 1.0, 1.0]).tolist()]
    worst = max(float(x.rad()) / scale for x, scale in zip(zero.start, scales, strict=True))
    worst = max(worst, float(zero.period.rad()) / float(zero.period.mid()))
    return -math.log10(worst) if worst else math.inf


def _condition(candidate: Candidate) -> float:
    """Of the ten equations, in double."""
    on, orbit = candidate.on, candidate.closed
    assert not isinstance(orbit, str)
    rows = at_level(on, orbit.state)(orbit.state, orbit.period)[1]
    sizes = np.linalg.svd(bordered(on, orbit.state, orbit.state, orbit.monodromy, rows))[1]
    return float(sizes[0] / sizes[-1]) if sizes[-1] else math.inf


def _refusal(candidate: Candidate, why: str) -> str:
    """What the checker refused, and what may be done about it."""
    if isinstance(candidate.closed, str):
        return f"no periodic orbit is near the start, {candidate.closed}: {why}; try another start"
    condition = _condition(candidate)
    if condition > _SINGULAR:
        return (
            f"the orbit is not isolated, or nearly so: {why}; the ten equations have the condition "
            f"{condition:.1g}, a further multiplier is about 1; try another level"
        )
    times, _, rest = why.removeprefix("the period may be ").partition(" times the least one")
    if not rest and times.isdigit():
        shorter = candidate.closed.period * float(candidate.on.unit) / int(times)
        return f"{why}; try the period {shorter:.10g}"
    return f"{why}; try more digits, or another orbit"


# -- many bodies ----------------------------------------------------------------------------------


def _of_bodies(candidate: Candidate, proof: OrbitProof, tolerance: Fraction) -> OrbitProof:
    """The certificate of all bodies; raises NotProved, with the widest tolerance that works.

    The box is to hold the orbits of all of them, on the one level, and Krawczyk's test fails for a
    box that is too small as for one that is too large.
    """
    try:
        return _of_all(candidate, proof, tolerance)
    except verify.NotProved as why:
        cause = str(why)
    for narrower in _below(tolerance):
        try:
            _of_all(candidate, proof, narrower)
        except verify.NotProved:
            continue
        widest = f"the largest power of 10 that works is {brief(narrower)}"
        break
    else:
        widest = f"none down to 1e-{_NARROWEST} works"
    sentence = f"no proof for all bodies within {brief(tolerance)} ({cause}): {widest}"
    raise NotProved(f"{candidate.name}: {sentence}")


def _of_all(candidate: Candidate, proof: OrbitProof, tolerance: Fraction) -> OrbitProof:
    """The proof in the first box that is large enough; raises the checker's NotProved."""
    on, bits = candidate.on, math.floor(-math.log2(to_double(tolerance)))
    start = _in_principal_axes(on.scene.body, [middle(x) for x in proof.zero.start])
    period = middle(proof.zero.period)
    problem = Problem(on.scene.body, on.h, on.f, start, period, tolerance)
    last = verify.NotProved("no box is large enough")
    for more in _BOXES:
        if more >= bits:  # a radius of 1
            break
        choice = Choice(Fraction(2) ** (more - bits), max(verify.COARSE, bits + _FINER), _SHORT)
        certificate = orbit_certificate.guesses(problem, choice)
        try:
            zero = orbit_certificate.proved(certificate)
        except verify.NotProved as why:
            last = why
            if _TOO_WIDE in str(why):
                break
            continue
        # a box about a centre that is off by its own size tells of no neighbourhood
        if min(zero.alone) > 0 and not zero.repeated:
            return OrbitProof(zero, certificate, _digits_of(candidate, zero), proof.runs + 1)
    raise last


def _in_principal_axes(body: Body, start: Sequence[Fraction]) -> list[Fraction]:
    """A state near the same one, as any guess is."""
    w, gamma = (body.axes.components((x, y, z)) for x, y, z in (start[:3], start[3:]))
    return [exact.binary(*exact.rounded(x, _BINARY)) if x else Fraction(0) for x in (*w, *gamma)]


def _below(tolerance: Fraction) -> Iterator[Fraction]:
    """Powers of 10 below a tolerance, downwards."""
    powers = (Fraction(1, 10**k) for k in range(1, _NARROWEST + 1))
    return (narrower for narrower in powers if narrower < tolerance)
