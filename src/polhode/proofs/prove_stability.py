"""``polhode.prove_stability``: a scene, or a proved orbit, to stability for all time."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from polhode.certificates import verify
from polhode.certificates.certificate_file import Made, by_checker
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.dynamics.orbit import Orbit
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber
from polhode.proofs.certified_orbit import BITS_A_DIGIT
from polhode.proofs.prove_orbit import DIGITS, MOST_DIGITS, prove_orbit
from polhode.proofs.proved_orbit import ProvedOrbit, ball_of
from polhode.proofs.proved_stability import ProvedStability
from polhode.proofs.refusals import NotProved
from polhode.scenes.scene import Scene

_GUIDE = verify.Guide(jet_bits=96, weight_bits=10)
_HEAVIER = 16  # bits of 1/rho, where larger ones are needed
_TRIES = 5
_DIGITS = 8  # of the twist
_SPARE = 8  # bits
_MORE = 5  # digits of the orbit beyond those that its twist lacks
_UNKNOWN = 17  # digits that are taken to lack where there are none
_TOO_FAST, _FOURTH = "the condition of the step", "resonance of the fourth order"

#: An orbit, proved with so many digits.
Prover = Callable[[int], ProvedOrbit]


def prove_stability(
    scene: Scene | str | Path | ProvedOrbit,
    orbit: Orbit | Scene | str | Path | None = None,
    digits: int = DIGITS,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    period: AnyNumber | None = None,
    returns: int | None = None,
    progress: Message | None = None,
) -> ProvedStability:
    """Prove that a periodic orbit is stable for all time, by Moser's theorem.

    Parameters
    ----------
    scene : Scene, str, Path or ProvedOrbit
        A scene, a path, or the name of a case: its body, and the level unless that is given.  Or an
        orbit that :func:`polhode.prove_orbit` proved for the scene's body alone.
    orbit : Orbit, Scene, str or Path, optional
        A guess: an orbit of the scene's body, as :func:`polhode.orbit` gives it, or a scene that
        ends after one period.  Without one, an orbit near the scene's start is searched for.
    digits : int
        The digits wanted of start and period (30, at most 200).
    h, f : number, optional
        The level's energy h or vertical momentum f, exact, if not the scene's.
    period, returns : number and int, optional
        A guess of the period, or the number of near returns to try, as in :func:`polhode.orbit`.
    progress : callable, optional
        Called with a line of text now and then.

    Returns
    -------
    ProvedStability
        The orbit, the rotation around it and its twist, as balls, and the theorem.

    Raises
    ------
    NotProved
        An orbit that is not proved, or is not elliptic, a resonance, or a twist that may be 0.
    BadInput
        A level that does not exist, a period that cannot be.

    Notes
    -----
    The theorem and what it does not say: ``polhode guide theorems``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_stability("grioli/precession")
    >>> found
    <ProvedStability of grioli/precession: period 6.28319, twist -23.6475>
    """
    if not isinstance(scene, ProvedOrbit):
        start = scene

        def prove(places: int) -> ProvedOrbit:
            return prove_orbit(start, orbit, places, h, f, period, returns, progress)

        return of_orbit(prove(digits), prove, progress)
    if any(x is not None for x in (orbit, h, f, period, returns)):
        raise BadInput(scene.scene.name, "scene", None, "nothing else with an orbit that is proved")
    return of_orbit(scene, near(scene), progress)


def near(orbit: ProvedOrbit) -> Prover:
    """What proves an orbit anew, with more digits."""
    p, q, r = (x.centre for x in orbit.omega)
    a, b, c = (x.centre for x in orbit.gamma)
    scene = replace(orbit.scene, omega=(p, q, r), gamma=(a, b, c), normalise=True)
    guess = scene.at([orbit.period.centre])
    return lambda places: prove_orbit(orbit.scene, guess, places, orbit.h, orbit.f)


def of_orbit(orbit: ProvedOrbit, prove: Prover, progress: Message | None = None) -> ProvedStability:
    """The theorem of a proved orbit; raises NotProved, BadInput."""
    began, name = time.process_time(), orbit.scene.name
    if orbit.tolerance:
        raise BadInput(name, "tolerance", orbit.tolerance, "none: an orbit of the one body")
    _refuse_unstable(orbit)
    orbit, proof, runs = _proof_of(orbit, prove, progress)
    rotation, twist = ball_of(proof.twist.rotation), ball_of(proof.twist.twist)
    parts: Made = json.loads(orbit.certificate)
    claim = parts["statement"]
    assert isinstance(claim, dict)
    balls = {"rotation": [*rotation.decimals], "twist": [*twist.decimals]}
    statement = {**claim, **balls}
    try:
        with ctx.workprec(proof.guide.jet_bits + verify.COARSE):
            verify.check_twist(verify.read_stability(statement)[1], proof.twist)
    except verify.NotProved:
        raise NotProved(f"{name}: the twist {proof.twist.twist.str(3)} may be 0") from None
    text = json.dumps(parts | proof.guide._asdict() | {"kind": "stability", "statement": statement})
    seconds = orbit.seconds + time.process_time() - began
    return ProvedStability(orbit, rotation, twist, proof.guide.jet_bits, runs, seconds, text)


class _Proof(NamedTuple):
    guide: verify.Guide
    twist: verify.Twist

    @property
    def digits(self) -> float:
        """Of the twist."""
        size, radius = abs(float(self.twist.twist.mid())), float(self.twist.twist.rad())
        return math.log10(size / radius) if size and 0.0 < radius < math.inf else -1.0


def _refuse_unstable(orbit: ProvedOrbit) -> None:
    """Raise NotProved where the multipliers forbid the theorem."""
    name = orbit.scene.name
    if orbit.kind != "elliptic":
        multiplier = max((x for x, _ in orbit.multipliers), key=lambda x: abs(x.centre))
        raise NotProved(
            f"{name}: the orbit is {orbit.kind} (multiplier {multiplier}): it is not stable"
        )
    if _may_be(orbit, Fraction(3, 4)):
        raise NotProved(
            f"{name}: a multiplier may be a third root of unity (residue {orbit.residue}): such "
            "orbits are stable only by exception, and nothing is decided"
        )


def _proof_of(
    orbit: ProvedOrbit, prove: Prover, progress: Message | None
) -> tuple[ProvedOrbit, _Proof, int]:
    """The orbit, perhaps with more digits, its twist, and after how many runs of jets.

    Of the start's ball and the jets' rounding the wider one is made narrower.
    """
    guide, best, why = _GUIDE, None, ""
    zero = by_checker(verify.zero_near, json.loads(orbit.certificate))
    for run in range(1, _TRIES + 1):
        if progress is not None:
            progress(f"return map {run}, {guide.jet_bits} bits")
        try:
            proof = _Proof(guide, by_checker(verify.twist_of, zero, guide))
            best, missing = (orbit, proof), _DIGITS - proof.digits
        except verify.NotProved as fault:
            why, missing = str(fault), _UNKNOWN
            if run > 1:
                guide = guide._replace(weight_bits=_HEAVIER)
        resonant = _FOURTH in why and _may_be(orbit, Fraction(1, 2))
        if missing <= 0 or resonant or run == _TRIES:
            break
        digits = math.ceil(orbit.digits + missing) + _MORE
        if BITS_A_DIGIT * orbit.digits < guide.jet_bits and digits <= MOST_DIGITS:
            orbit = prove(digits)
            zero = by_checker(verify.zero_near, json.loads(orbit.certificate))
        else:
            bits = guide.jet_bits + math.ceil(BITS_A_DIGIT * missing) + _SPARE
            guide = guide._replace(jet_bits=bits)
    if best is None:
        raise NotProved(f"{orbit.scene.name}: {_advice(orbit, why, guide)}")
    return *best, run


def _may_be(orbit: ProvedOrbit, residue: Fraction) -> bool:
    return abs(orbit.residue.centre - residue) <= Fraction(orbit.residue.radius)


def _advice(orbit: ProvedOrbit, why: str, guide: verify.Guide) -> str:
    """What the checker refused, and what may be done about it."""
    if _TOO_FAST in why:
        return f"the jets grow too fast for {guide.jet_bits} bits ({why}): try a shorter orbit"
    if _FOURTH in why:
        return (
            f"a multiplier may be i (residue {orbit.residue}), and the term of that resonance may "
            "be as large as the twist: nothing is decided"
        )
    return f"{why}; try more digits"
