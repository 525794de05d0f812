"""Proved stability: an elliptic orbit that motions near it never leave, a theorem."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple, Unpack

from polhode.certificates import verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.arguments import refuse_unknown, with_options, with_progress
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.orbit import NearOrbit, Orbit
from polhode.numbers.decimals import Ball
from polhode.proofs.orbit_certificate import BITS_A_DIGIT
from polhode.proofs.proved_orbit import DIGITS, MOST_DIGITS, ProvedOrbit, ball_of, prove_orbit
from polhode.proofs.theorem import NotProved, Theorem
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts

# --- theorem --------------------------------------------------------------------------------------


_ROTATION = "turns around the orbit in a period, from 0 to 1/2"
_TWIST = "radians a period per unit of action"


@dataclass(frozen=True, eq=False, repr=False)
class ProvedStability(Theorem, ByValue):
    """A periodic orbit that is stable for all time: a theorem about every motion near it.

    ``orbit``: the proved elliptic orbit.  ``rotation``: of neighbouring motions around it, in turns
    a period, between 0 and 1/2.  ``twist``: how that angle, in radians, changes with the action,
    the canonical area over 2 pi that a motion goes around on a section of the level; it is not 0.
    ``bits``: of the jets of the return map; ``runs``: of the checker's part on the return map;
    ``seconds``: CPU time, the orbit's included.  ``certificate``: the JSON text that ``polhode
    verify`` checks.

    >>> import polhode
    >>> found = polhode.prove_stability("grioli/precession")
    >>> str(found.rotation)[:12], found.orbit.kind
    ('0.0157568772', 'elliptic')
    """

    orbit: ProvedOrbit
    rotation: Ball
    twist: Ball
    bits: int
    runs: int
    seconds: float = field(compare=False)
    certificate: str

    @property
    def scene(self) -> Scene:
        """The orbit's."""
        return self.orbit.scene

    @property
    def provenance(self) -> Mapping[str, object]:
        """The orbit's."""
        return self.orbit.provenance

    def table(self) -> Table:
        """One row: the orbit's, with rotation and twist."""
        orbit = self.orbit.table()
        columns = [
            Column("rotation", [self.rotation], _ROTATION),
            Column("twist", [self.twist], _TWIST),
        ]
        return Table([*orbit.columns[:4], *columns, *orbit.columns[4:]])

    def facts(self) -> list[Fact]:
        """The theorem, its numbers as balls, and what it took."""
        names = ("h", "f", "period", "kind", "residue", "digits_proven")
        return [
            *scene_facts(self.scene),
            Fact("proven", True),
            Fact("theorem", self.theorem),
            *(fact for fact in self.orbit.facts() if fact.name in names),
            Fact("rotation", self.rotation, _ROTATION),
            Fact("twist", self.twist, _TWIST),
            Fact("bits", self.bits, "of the jets of the return map"),
            Fact("runs", self.runs, "of the checker's part on the return map"),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        period, twist = float(self.orbit.period), float(self.twist)
        return f"<ProvedStability of {self.scene.name}: period {period:.6g}, twist {twist:.6g}>"

    def __str__(self) -> str:
        """The numbers, a line each, and the theorem."""
        # the proven digits, or the ball where not even one is known
        orbit, twist = self.orbit, str(self.twist) or " +- ".join(self.twist.decimals)
        lines = [
            f"period      {orbit.period}",
            f"level       {orbit.level}",
            f"residue     {orbit.residue}, {orbit.kind}",
            f"rotation    {self.rotation} of a turn in a period",
            f"twist       {twist} (radians per unit of action)",
        ]
        return "\n".join([*lines, self.theorem])

    @property
    def theorem(self) -> str:
        """The theorem in words."""
        orbit = self.orbit
        return (
            f"proved: on the level {orbit.level} the periodic orbit through {orbit.point} with the "
            f"period {orbit.period} is stable for all time, forward and back: for each d > 0 a "
            "motion of omega and gamma that starts near enough to it, on its level or another, "
            "stays within d of it; tori of quasi-periodic motions enclose it (J. Moser). How near "
            "is not known; psi may drift."
        )


# --- prove stability ------------------------------------------------------------------------------


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


@with_options(NearOrbit)
@with_progress
def prove_stability(
    scene: Scene | str | Path | ProvedOrbit,
    orbit: Orbit | Scene | str | Path | None = None,
    digits: int | None = None,
    **near: Unpack[NearOrbit],
) -> ProvedStability:
    """Prove that a periodic orbit is stable for all time, by Moser's theorem.

    Parameters
    ----------
    scene : Scene, str, Path or ProvedOrbit
        A scene, a path, or the name of a case: its body, and the level unless that is given.  Or an
        orbit that :func:`polhode.prove_orbit` proved, with nothing beside it.
    orbit : Orbit, Scene, str or Path, optional
        A guess: an orbit of the scene's body, as :func:`polhode.orbit` gives it, or a scene that
        ends after one period.  Without one, an orbit near the scene's start is searched for.
    digits : int, optional
        The digits wanted of start and period (30, at most 200).

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
    refuse_unknown("prove_stability", prove_stability, near)
    progress = near.get("progress")
    start: Scene | str | Path
    if isinstance(scene, ProvedOrbit):
        first, start = scene, scene.scene
        options = (orbit, digits, *(x for x in near.values() if x is not progress))
        if any(x is not None for x in options):
            expected = "nothing else with an orbit that is proved"
            raise BadInput(first.scene.name, "scene", None, expected)
        orbit, near = first.near, NearOrbit(h=first.h, f=first.f)
    else:
        first = prove_orbit(scene, orbit, DIGITS if digits is None else digits, **near)
        start = scene

    def prove(places: int) -> ProvedOrbit:
        return prove_orbit(start, orbit, places, **near)

    began, name = time.process_time(), first.scene.name
    _refuse_unstable(first)
    proved, proof, runs = _proof_of(first, prove, progress)
    rotation, twist = ball_of(proof.twist.rotation), ball_of(proof.twist.twist)
    parts: JsonObject = json.loads(proved.certificate)
    claim = parts["statement"]
    assert isinstance(claim, dict)
    balls = {"rotation": [*rotation.decimals], "twist": [*twist.decimals]}
    statement = {**claim, **balls}
    balls_stated, bits = verify.read_stability(statement)[1], proof.guide.jet_bits + verify.COARSE
    try:
        by_checker(verify.check_twist, balls_stated, proof.twist, bits=bits)
    except verify.NotProved:
        raise NotProved(f"{name}: the twist {proof.twist.twist.str(3)} may be 0") from None
    text = json.dumps(parts | proof.guide._asdict() | {"kind": "stability", "statement": statement})
    seconds = proved.seconds + time.process_time() - began
    return ProvedStability(proved, rotation, twist, proof.guide.jet_bits, runs, seconds, text)


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
            by_checker(verify.read_guide, json.loads(orbit.certificate) | guide._asdict())
            proof = _Proof(guide, by_checker(verify.twist_of, zero, guide))
            best, missing = (orbit, proof), _DIGITS - proof.digits
        except verify.NotProved as fault:
            why, missing = str(fault), _UNKNOWN
            if run > 1:
                guide = guide._replace(weight_bits=_HEAVIER)
        except verify.Damaged as fault:  # of too many steps
            raise NotProved(f"{orbit.scene.name}: {fault}; try a shorter orbit") from None
        resonant = _FOURTH in why and _may_be(orbit, Fraction(1, 2))
        if missing <= 0 or resonant or run == _TRIES:
            break
        digits = math.ceil(orbit.digits + missing) + _MORE
        if BITS_A_DIGIT * orbit.digits < guide.jet_bits and digits <= MOST_DIGITS:
            try:
                orbit = prove(digits)
            except NotProved:
                if best is None:
                    raise
                break
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
