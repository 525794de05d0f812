"""Proved chaos: the theorem in words and in the scene's units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from polhode.certificates import verify
from polhode.certificates.chaos_certificate import Chart, Rectangle
from polhode.common.errors import counted
from polhode.common.values import ByValue
from polhode.numbers.exact import Exact
from polhode.proofs.homoclinic import Lanes, Saddle
from polhode.proofs.proved_orbit import ProvedOrbit, down, up
from polhode.proofs.proved_result import ProvedResult
from polhode.results.table import Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of


class Guess(NamedTuple):
    """What the proof began with, in principal axes and the unit of time of the lanes.

    ``sets``: N0, M1, ..., Mk; ``times``: of each to the next one's plane.
    """

    lanes: Lanes
    saddle: Saddle
    charts: list[Chart]
    sets: list[Rectangle]
    times: list[float]


@dataclass(frozen=True, eq=False, repr=False)
class ProvedChaos(ProvedResult, ByValue):
    """A level on which the motion is chaotic: a theorem.

    ``orbit``: the proved unstable periodic orbit whose manifolds meet.  ``sets``, ``coverings``:
    of the proof.  ``entropy``: a lower bound of the flow's topological entropy on the level, per
    unit of the scene's time.  ``short``, ``long``: upper bounds of the times of the two loops.
    ``stretch``, ``height``, ``cone``: the least, largest and least margin; the conditions are
    stretch > 1, height < 1, cone > 0.  ``size``: of the sets, in the proof's scale.  ``tries``: of
    homoclinic orbits and sizes; ``seconds``: CPU.  ``certificate``: the JSON text that ``polhode
    verify`` checks.  ``guess``, ``images``: the sets and where they were proved to go, for figures.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_chaos("general/asymmetric-chaotic")
    >>> found
    <ProvedChaos of general/asymmetric-chaotic: 20 coverings, entropy at least 2.7e-02>
    """

    scene: Scene
    h: Exact
    f: Exact
    orbit: ProvedOrbit
    sets: int
    coverings: int
    entropy: float
    short: float
    long: float
    stretch: float
    height: float
    cone: float
    size: float
    tries: int
    seconds: float = field(compare=False)
    certificate: str
    guess: Guess = field(compare=False)
    images: tuple[verify.Image, ...] = field(compare=False)
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)

    def table(self) -> Table:
        """One row: the orbit whose manifolds meet, as balls."""
        return self.orbit.table()

    def facts(self) -> list[Fact]:
        """The theorem, its bounds and margins, and what it took."""
        time = unit_of(self.scene, "t")
        return [
            *scene_facts(self.scene),
            Fact("proven", True),
            Fact("theorem", self.theorem),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("entropy", self.entropy, "lower bound of the topological entropy", f"1/{time}"),
            Fact("loops", [self.short, self.long], "upper bounds of their times", time),
            Fact("sets", self.sets),
            Fact("coverings", self.coverings),
            Fact("stretch", self.stretch, "the least; above 1"),
            Fact("height", self.height, "the largest; below 1"),
            Fact("cone", self.cone, "the least; above 0"),
            Fact("size", self.size, "of the sets, in the proof's scale"),
            Fact("tries", self.tries, "of homoclinic orbits and sizes"),
            *(x for x in self.orbit.facts() if x.name in ("kind", "multipliers", "digits_proven")),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        coverings = counted(self.coverings, "covering")
        entropy = down(self.entropy)
        return f"<ProvedChaos of {self.scene.name}: {coverings}, entropy at least {entropy}>"

    def __str__(self) -> str:
        """The numbers, a line each, and the theorem."""
        orbit = self.orbit
        lines = [
            f"level       {orbit.level}",
            f"orbit       {orbit.kind}, period {orbit.period}, "
            f"multiplier {orbit.multipliers[0][0]}",
            f"sets        {self.sets}, {self.coverings} coverings with cones",
            f"margins     stretch {self.stretch:.3g} > 1, height {self.height:.3g} < 1, "
            f"cone {self.cone:.3g} > 0",
            f"loops       shorter than {up(self.short)} and {up(self.long)}",
            f"entropy     at least {down(self.entropy)}",
        ]
        return "\n".join([*lines, self.theorem])

    @property
    def theorem(self) -> str:
        """The theorem in words."""
        period, radius = self.orbit.period.decimals
        return (
            f"proved: on the level {self.orbit.level} the {self.orbit.kind} periodic orbit of "
            f"least period {period} +- {radius} has a transversal homoclinic orbit; for "
            f"every sequence of two loops, shorter than {up(self.short)} and {up(self.long)}, "
            f"exactly one motion follows it, a periodic one if the sequence is periodic; the "
            f"topological entropy of the motion on the level is at least {down(self.entropy)}"
        )
