"""Periodic orbits as JSON objects and arrays; names and shapes are a contract."""

from __future__ import annotations

import math
from fractions import Fraction

from polhode.common.json_text import JsonObject
from polhode.dynamics.periodic_orbits import high_precision
from polhode.dynamics.periodic_orbits.families import Bifurcation, FamilyPoint, OrbitFamily
from polhode.dynamics.periodic_orbits.orbit import Orbit
from polhode.dynamics.periodic_orbits.search import OrbitSearch
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string, in_full, shown
from polhode.numbers.exact import Exact


def of_orbit(found: Orbit) -> JsonObject:
    """The object that ``orbit --json`` prints."""
    gamma = found.scene.gamma or ()
    return {
        "scene": found.name,
        "h": shown(found.h),
        "f": shown(found.f),
        "digits": found.digits,
        "period": decimal(found.period, found.digits + 2),
        "omega": [decimal(x, found.digits + 2) for x in found.scene.omega],
        "gamma": [_placed(x, found.digits + 2) for x in gamma],
        "error": found.error,
        "kind": found.kind,
        "residue": residue(found),
        "residue_error": found.residue_error,
        "multipliers": [[real, imaginary] for real, imaginary in multipliers(found)],
        "determinant": found.determinant,
        "psi": None if found.psi is None else _placed(exactly(found.psi), found.digits),
        "psi_with_turns": found.psi_whole,
        "psi_turns": None if found.turns is None else str(found.turns),
        "moved": found.moved,
        "corrections": list(found.corrections),
        "provenance": dict(found.provenance),
    }


def of_family(found: OrbitFamily) -> JsonObject:
    """The object that ``orbit --continue --json`` prints."""
    return {
        "scene": found.scene.name,
        "by": found.by,
        "ended": found.ended,
        "orbits": [_point(point) for point in found.points],
        "bifurcations": [_bifurcation(one) for one in found.bifurcations],
        "provenance": dict(found.provenance),
    }


def of_search(found: OrbitSearch) -> JsonObject:
    """The object that ``orbit --search --json`` prints."""
    return {
        "scene": found.scene.name,
        "h": shown(found.surface.h),
        "f": shown(found.surface.f),
        "guesses": found.guesses,
        "interrupted": found.interrupted,
        "orbits": [_point(point) for point in found.orbits],
        "provenance": dict(found.provenance),
    }


def arrays(found: OrbitFamily | OrbitSearch) -> JsonObject:
    """The arrays of an NPZ file: ``state`` (n, 6), ``h``, ``f``, ``period``, ``residue``."""
    import numpy as np

    from polhode.common import json_text

    family = isinstance(found, OrbitFamily)
    points = found.points if isinstance(found, OrbitFamily) else found.orbits
    about = of_family(found) if isinstance(found, OrbitFamily) else of_search(found)
    held: JsonObject = {
        name: np.array([getattr(point, name) for point in points])
        for name in ("h", "f", "period", "residue", "state")
    }
    if family:
        del about["orbits"]
    return held | {"about": np.array(json_text.as_json(about))}


def residue(found: Orbit) -> str:
    """A residue with the digits that are known of it."""
    return _known(exactly(found.residue), found.residue_error, found.digits)


def multipliers(found: Orbit) -> list[tuple[str, str]]:
    """Real and imaginary part of both, with the digits that are known."""
    pairs, most = [], found.digits
    for parts in found.multipliers:
        real, imaginary = map(exactly, parts)
        one, size = complex(*map(float, parts)), max(1.0, abs(float(real)))
        # mu - 1/mu divides the error of mu + 1/mu = 2 - 4R; near +-1 its root is taken
        apart = abs(one - 1 / one)
        error = 4 * found.residue_error * size / max(apart, math.sqrt(found.residue_error))
        pairs.append((_known(real, error, most), _known(imaginary, error, most)))
    return pairs


def decimal(x: Exact, digits: int) -> str:
    """x to so many digits: its own where it has no more."""
    if isinstance(x, Fraction):
        text = in_full(x)
        if "/" not in text and len(text.strip("-0.")) <= digits:
            return text
    return decimal_string(exact.binary(*exact.rounded(x, 4 * digits + 8)), digits)


def _placed(x: Exact, digits: int) -> str:
    """A component of a unit vector to so many places."""
    near = exact.binary(*exact.rounded(x, 4 * digits + 8)) if x else Fraction(0)
    return high_precision.decimal(near, Fraction(1), digits)


def _known(x: Fraction, error: float, most: int) -> str:
    """x as far as an error leaves digits, and no more than so many; 0 where it leaves none."""
    if not x:
        return "0"
    left = math.floor(exact.log10(abs(x)) - math.log10(error))
    return decimal_string(x, min(left, most)) if left >= 1 else "0"


def _point(point: FamilyPoint) -> JsonObject:
    return {
        "h": point.h,
        "f": point.f,
        "period": point.period,
        "residue": point.residue,
        "kind": point.kind,
        "state": list(point.state),
    }


def _bifurcation(one: Bifurcation) -> JsonObject:
    return {"what": one.what, "after": one.after, **_point(one.point)}
