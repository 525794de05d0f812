"""Values of a top, each digit of which is proved; and the certificate of that."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction

from polhode.benchmark.tops import DIGITS, Top
from polhode.certificates import state_certificate
from polhode.certificates.certificate_file import Made
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.enclosures.certify import certify
from polhode.enclosures.result import Enclosure
from polhode.enclosures.statement import LENGTH
from polhode.equations.kinematics import starting_attitude
from polhode.numbers.exact import Exact, binary, rounded
from polhode.scenes import library
from polhode.scenes.scene import Scene

COLUMNS = ("t", "p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3")
_BEYOND = (8, 20, 60)  # digits more than those that are written, where fewer leave a doubt
_BITS = 1000  # of irrational numbers of a start, from which its decimals are made


@dataclass(frozen=True)
class CertifiedValues:
    """A top's values, correctly rounded: rows of ten decimals, of t = 0 first.

    ``places``: behind the point, of the three numbers of omega and of the other seven.
    """

    scene: Scene
    times: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    places: tuple[int, int]

    def certificate(self, progress: Progress | None = None) -> Made:
        """The certificate that each value is right to its last place, as JSON's objects."""
        gamma = self.scene.gamma
        assert gamma is not None
        units = [_just_over_half(self.places[k >= 3]) for k in range(10)]
        balls = [[(x, unit) for x, unit in zip(row, units, strict=True)] for row in self.rows[1:]]
        turned = state_certificate.Attitude(
            starting_attitude(gamma, self.scene.psi), [row[6:] for row in balls]
        )
        times = [Fraction(t) for t in self.times[1:]]
        return state_certificate.certificate(
            self.scene, times, [row[:6] for row in balls], progress, turned
        )

    @property
    def csv(self) -> str:
        """The file of values."""
        lines = [",".join((t, *row)) for t, row in zip(self.times, self.rows, strict=True)]
        return "\n".join([",".join(COLUMNS), *lines]) + "\n"


def certified_values(top: Top, progress: Progress | None = None) -> CertifiedValues:
    """The values of a top at its times, proved by an enclosure."""
    scene = replace(library.load(top.case), outputs=("attitude",))
    times = [Fraction(t) for t in top.times]
    for more in _BEYOND:
        found = certify(scene, times, digits=DIGITS + more, progress=progress)
        if set(found.assumed) - {LENGTH}:  # which the certificate does not rest on
            raise BadInput(top.case, "start", None, "numbers that need no rule for equal ones")
        size = max(math.hypot(*map(float, row[:3])) for row in found.centres)
        places = DIGITS - math.floor(math.log10(size)), DIGITS
        rows = _rows(found, places)
        if rows is not None:
            return CertifiedValues(scene, ("0", *top.times), (_start(scene, places), *rows), places)
    raise BadInput(top.case, "run.at", None, "times at which no value is halfway")


def _rows(found: Enclosure, places: tuple[int, int]) -> list[tuple[str, ...]] | None:
    """The balls as correctly rounded decimals; None where one leaves a doubt."""
    assert found.attitude is not None
    rows = []
    for centres, turn, radii, off in zip(
        found.centres, found.attitude.centres, found.radii, found.attitude.radii, strict=True
    ):
        row = []
        for k, (x, radius) in enumerate(zip((*centres, *turn), (*radii, *off), strict=True)):
            unit = 10 ** places[k >= 3]
            assert x is not None
            low, high = (round((x + side * Fraction(radius)) * unit) for side in (-1, 1))
            if low != high:
                return None
            row.append(_decimal(low, places[k >= 3]))
        rows.append(tuple(row))
    return rows


def _start(scene: Scene, places: tuple[int, int]) -> tuple[str, ...]:
    """The scene's own start, rounded as the values are."""
    gamma = scene.gamma
    assert gamma is not None
    numbers: list[Exact] = [*scene.omega, *gamma, *starting_attitude(gamma, scene.psi)]
    found = []
    for k, x in enumerate(numbers):
        near = x if isinstance(x, Fraction) else binary(*rounded(x, _BITS))
        found.append(_decimal(round(near * 10 ** places[k >= 3]), places[k >= 3]))
    return tuple(found)


def _decimal(value: int, places: int) -> str:
    """value 10^-places, in full."""
    return f"{Decimal((int(value < 0), tuple(map(int, str(abs(value)))), -places)):f}"


def _just_over_half(places: int) -> str:
    """0.51 of a unit of the last place: a correctly rounded value is within a half."""
    return f"5.1e-{places + 1}"
