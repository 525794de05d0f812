"""Proved stability: an elliptic orbit that motions near it never leave, a theorem."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from polhode.common.values import ByValue
from polhode.numbers.decimals import Ball
from polhode.proofs.proved_orbit import ProvedOrbit
from polhode.proofs.proved_result import ProvedResult
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts

_ROTATION = "turns around the orbit in a period, from 0 to 1/2"
_TWIST = "radians a period per unit of action"


@dataclass(frozen=True, eq=False, repr=False)
class ProvedStability(ProvedResult, ByValue):
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
        orbit = self.orbit
        lines = [
            f"period      {orbit.period}",
            f"level       {orbit.level}",
            f"residue     {orbit.residue}, {orbit.kind}",
            f"rotation    {self.rotation} of a turn in a period",
            f"twist       {self.digits_of_twist} (radians per unit of action)",
        ]
        return "\n".join([*lines, self.theorem])

    @property
    def digits_of_twist(self) -> str:
        """The proven digits, or the ball where not even one is known."""
        return str(self.twist) or " +- ".join(self.twist.decimals)

    @property
    def theorem(self) -> str:
        """The theorem in words."""
        orbit = self.orbit
        point = " and ".join(
            f"{name} ({', '.join(map(str, balls))})"
            for name, balls in (("omega", orbit.omega), ("gamma", orbit.gamma))
        )
        return (
            f"proved: on the level {orbit.level} the periodic orbit through {point} with the "
            f"period {orbit.period} is stable for all time, forward and back: for each d > 0 a "
            "motion of omega and gamma that starts near enough to it, on its level or another, "
            "stays within d of it; tori of quasi-periodic motions enclose it (J. Moser). How near "
            "is not known; psi may drift."
        )
