"""Proved periodic orbits and proved chaos as JSON objects; names and shapes are a contract."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from polhode.numbers.decimals import brief, shown

if TYPE_CHECKING:
    from polhode.numbers.balls import Ball
    from polhode.proofs.chaos.proved_chaos import ProvedChaos
    from polhode.proofs.proved_orbit import ProvedOrbit
    from polhode.proofs.refusals import NotProved


def of_proof(found: ProvedOrbit) -> dict[str, object]:
    """The object that ``prove orbit --json`` prints.

    Numbers are decimals of which every digit is proven; in ``balls`` the same as midpoint and
    radius.
    """
    names = ("period", "residue")
    vectors = {"omega": found.omega, "gamma": found.gamma}
    multipliers = found.multipliers
    return {
        "scene": found.scene.name,
        "proved": True,
        "theorem": str(found),
        "h": shown(found.h),
        "f": shown(found.f),
        "tolerance": brief(found.tolerance),
        "period": str(found.period),
        **{name: [str(x) for x in balls] for name, balls in vectors.items()},
        "residue": str(found.residue),
        "kind": found.kind,
        "multipliers": [[str(x) for x in pair] for pair in multipliers],
        "unique_within": found.unique_within._asdict(),
        "balls": {
            **{name: _ball(getattr(found, name)) for name in names},
            **{name: [_ball(x) for x in balls] for name, balls in vectors.items()},
            "multipliers": [[_ball(x) for x in pair] for pair in multipliers],
        },
        "digits_proven": round(found.digits - 0.005, 2),
        "bits": found.bits,
        "runs": found.runs,
        "seconds": round(found.seconds, 3),
        "provenance": dict(found.provenance),
    }


def of_result(found: ProvedOrbit | NotProved) -> dict[str, object]:
    """A proof, or why there is none."""
    if isinstance(found, ArithmeticError):
        return {"proved": False, "cause": str(found)}
    return of_proof(found)


def line_of(found: ProvedOrbit | NotProved) -> str:
    """The same in one line."""
    if isinstance(found, ArithmeticError):
        return f"not proved: {found}"
    period, radius = found.period.decimals
    return f"proved: {found.kind}, least period {period} +- {radius}, residue {found.residue}"


def all_proved(found: Sequence[ProvedOrbit | NotProved]) -> bool:
    """Whether nothing was refused."""
    return not any(isinstance(one, ArithmeticError) for one in found)


def count(found: Sequence[ProvedOrbit | NotProved]) -> str:
    """How many were proved."""
    refused = sum(isinstance(one, ArithmeticError) for one in found)
    return f"{len(found) - refused} of {len(found)} proved"


def lines(found: ProvedOrbit) -> list[str]:
    """The numbers for people, a line each."""
    from polhode.proofs.proved_orbit import down

    near = found.unique_within
    multipliers = []
    for real, imaginary in found.multipliers:
        sign, size = "-" if imaginary.centre < 0 else "+", str(imaginary).lstrip("-")
        multipliers.append(f"{real} {sign} {size} i" if imaginary.centre else str(real))
    return [
        f"period      {found.period}",
        f"omega       {', '.join(map(str, found.omega))}",
        f"gamma       {', '.join(map(str, found.gamma))}",
        f"level       {found.level}",
        *([f"bodies      {found.bodies.rstrip(', ')}"] if found.tolerance else []),
        f"residue     {found.residue}, {found.kind}",
        *(f"multiplier  {text}" for text in multipliers),
        f"alone       within {down(near.omega)} of omega and {down(near.gamma)} of gamma, "
        f"with a period within {down(near.period)}",
    ]


def of_chaos(found: ProvedChaos) -> dict[str, object]:
    """The object that ``prove chaos --json`` prints; bounds are decimals on the safe side."""
    from polhode.proofs.proved_orbit import down, up

    return {
        "scene": found.scene.name,
        "proved": True,
        "theorem": str(found),
        "h": shown(found.h),
        "f": shown(found.f),
        "entropy_at_least": down(found.entropy),
        "loops_at_most": [up(found.short), up(found.long)],
        "sets": found.sets,
        "coverings": found.coverings,
        "margins": {
            "least_stretch": found.stretch,
            "largest_height": found.height,
            "least_cone": found.cone,
        },
        "size": found.size,
        "tries": found.tries,
        "orbit": of_proof(found.orbit),
        "seconds": round(found.seconds, 3),
        "provenance": dict(found.provenance),
    }


def chaos_lines(found: ProvedChaos) -> list[str]:
    """The numbers for people, a line each."""
    from polhode.proofs.proved_orbit import down, up

    orbit = found.orbit
    return [
        f"level       {orbit.level}",
        f"orbit       {orbit.kind}, period {orbit.period}, multiplier {orbit.multipliers[0][0]}",
        f"sets        {found.sets}, {found.coverings} coverings with cones",
        f"margins     stretch {found.stretch:.3g} > 1, height {found.height:.3g} < 1, "
        f"cone {found.cone:.3g} > 0",
        f"loops       shorter than {up(found.short)} and {up(found.long)}",
        f"entropy     at least {down(found.entropy)}",
    ]


def _ball(x: Ball) -> list[str]:
    return [*x.decimals]
