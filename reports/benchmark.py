"""The heavy top benchmark: data, values and certificates of each top, checkers, and what it is."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import polhode
from kit import HERE, Only, Say, template, write
from polhode.certificates import state_certificate
from polhode.enclosures.statement import LENGTH
from polhode.equations.kinematics import starting_attitude

# --- tops -----------------------------------------------------------------------------------------
#
# The tops of the benchmark: which, why, and the times of their values.


#: Of the data: a value that changes, or another top, makes another version.
VERSION = "1"
#: Correct decimal digits of every value.
DIGITS = 50


class Top(NamedTuple):
    """A case of the library, what it is a test of, and the times of its values, in its unit."""

    case: str
    about: str
    times: tuple[str, ...]

    @property
    def name(self) -> str:
        """What its files are called."""
        return self.case.replace("/", "-")

    @property
    def proof(self) -> str:
        """The file of its certificate."""
        return f"{self.name}.certificate.json"


_SHORT = ("1", "2", "3", "4", "6", "8", "10", "12", "16", "20")
_LONG = ("1", "2", "5", "10", "15", "20", "25", "30", "40", "50")
_FAST = ("0.1", "0.2", "0.3", "0.5", "0.7", "1", "1.4", "2", "3", "4")
_RACING = ("0.02", "0.05", "0.1", "0.2", "0.3", "0.5", "0.7", "1", "1.5", "2")

TOPS = (
    Top("euler/largest-axis", "Euler's top, regular", _LONG),
    Top("euler/dzhanibekov", "Euler's top from 1e-6 off the middle axis: a flip", _LONG),
    Top("lagrange/nutation", "Lagrange's top, nutation", _LONG),
    Top("lagrange/looping", "Lagrange's top, loops", _LONG),
    Top("kovalevskaya/generic", "Kovalevskaya's top, generic", _LONG),
    Top("kovalevskaya/delaunay", "Kovalevskaya's top, Delaunay's motion", _LONG),
    Top("pendulum/rotating", "physical pendulum that turns over", _SHORT),
    Top("staude/unstable", "permanent rotation of Staude, unstable: errors grow", _SHORT),
    Top("grioli/precession", "Grioli's regular precession about a slanted axis", _LONG),
    Top("hess/loxodrome", "Hess's top, loxodrome: asymptotic", _SHORT),
    Top("bobylev-steklov/cn", "Bobylev and Steklov's motion", _SHORT),
    Top("goryachev-chaplygin/two-frequencies", "Goryachev and Chaplygin's top", _LONG),
    Top("goryachev/motion", "Goryachev's motion", _SHORT),
    Top("chaplygin/motion", "Chaplygin's motion of 1904", _SHORT),
    Top("steklov/upper", "Steklov's motion, unstable: errors grow", _SHORT),
    Top("n-kowalewski/motion", "N. Kowalewski's motion", _LONG),
    Top("general/asymmetric-regular", "asymmetric heavy top, no closed form", _LONG),
    Top("general/near-upright", "asymmetric heavy top let go near the upright position", _LONG),
    Top("published/hairer-vilmart", "asymmetric heavy top of Hairer and Vilmart", _SHORT),
    Top("hard/near-staude", "asymmetric heavy top 1e-12 off a permanent rotation", _SHORT),
    Top("general/asymmetric-chaotic", "asymmetric heavy top, chaotic", _LONG),
    Top("general/section", "asymmetric heavy top, chaotic, of a given energy and area", _LONG),
    Top("euler/needle", "needle whose moments differ by a factor of a million", _FAST),
    Top("published/bruels-cardona-arnold", "fast top of Bruels, Cardona and Arnold", _RACING),
)


# --- certified values -----------------------------------------------------------------------------
#
# Values of a top, each digit of which is proved; and the certificate of that.


COLUMNS = ("t", "p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3")
_BEYOND = (8, 20, 60)  # digits more than those that are written, where fewer leave a doubt


@dataclass(frozen=True)
class CertifiedValues:
    """A top's values, correctly rounded: rows of ten decimals, of t = 0 first.

    ``places``: behind the point, of the three numbers of omega and of the other seven.
    """

    scene: polhode.Scene
    times: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    places: tuple[int, int]

    @property
    def certificate(self) -> Any:
        """The certificate that each value is right to its last place, as JSON's objects."""
        gamma = self.scene.gamma
        assert gamma is not None
        # 0.51 of a unit of the last place: a correctly rounded value is within a half
        units = [f"5.1e-{self.places[k >= 3] + 1}" for k in range(10)]
        balls = [[*zip(row, units, strict=True)] for row in self.rows[1:]]
        times = [Fraction(t) for t in self.times[1:]]
        turn = starting_attitude(gamma, self.scene.psi)
        return state_certificate.certificate(self.scene, times, balls, None, turn)

    @property
    def csv(self) -> str:
        """The file of values."""
        lines = [",".join((t, *row)) for t, row in zip(self.times, self.rows, strict=True)]
        return "\n".join([",".join(COLUMNS), *lines]) + "\n"


def certified_values(top: Top) -> CertifiedValues:
    """The values of a top at its times, proved by an enclosure."""
    scene = replace(polhode.load(top.case), outputs=("attitude",))
    times = ("0", *top.times)
    for more in _BEYOND:
        enclosure = polhode.certify(scene, map(Fraction, times), digits=DIGITS + more)
        if set(enclosure.assumed) - {LENGTH}:  # which the certificate does not rest on
            expected = "numbers that need no rule for equal ones"
            raise polhode.BadInput(top.case, "start", None, expected)
        size = max(math.hypot(*map(float, row[:3])) for row in enclosure.centres[1:])
        places = DIGITS - math.floor(math.log10(size)), DIGITS
        rows = _rows(enclosure, places)
        if rows is not None:
            return CertifiedValues(scene, times, tuple(rows), places)
    raise polhode.BadInput(top.case, "run.at", None, "times at which no value is halfway")


def _rows(enclosure: polhode.Enclosure, places: tuple[int, int]) -> list[tuple[str, ...]] | None:
    """The balls as correctly rounded decimals; None where one leaves a doubt."""
    assert enclosure.attitude is not None
    rows = []
    for centres, radii, turn, off in zip(
        enclosure.centres, enclosure.radii, *enclosure.attitude, strict=True
    ):
        row = []
        for k, (x, radius) in enumerate(zip((*centres, *turn), (*radii, *off), strict=True)):
            unit = 10 ** places[k >= 3]
            assert x is not None
            low, high = (round((x + side * Fraction(radius)) * unit) for side in (-1, 1))
            if low != high:
                return None
            row.append(f"{Decimal(f'{low}e{-places[k >= 3]}'):f}")
        rows.append(tuple(row))
    return rows


# --- folder ---------------------------------------------------------------------------------------
#
# The benchmark's folder: data, values and certificates of each top, checkers, and what it is.


DATA, PAGE = "tops.json", "README.md"
CHECKERS = ("check.py", "check.c", "check.js")
SECONDS = 7  # of the processor that a top takes, about
NAME = "heavy top benchmark"
_PLACES = 60  # of decimals of data that have no end


def write_benchmark(folder: Path, only: Only, say: Say) -> Iterator[Path]:
    """Write the benchmark, each top's files as they are proved; the paths.

    ``only``: the names of the tops whose values and certificates alone are written.
    """
    chosen = [top for top in TOPS if only(top.name)]
    only.check()
    folder.mkdir(parents=True, exist_ok=True)
    values_of: dict[Top, CertifiedValues] = {}
    for n, top in enumerate(chosen):
        say(f"{top.name}, {n + 1} of {len(chosen)}; about {SECONDS} s each")
        values_of[top] = values = certified_values(top)
        certificate = json.dumps(values.certificate) + "\n"
        texts = {folder / f"{top.name}.csv": values.csv, folder / top.proof: certificate}
        yield from write(texts)
    if len(values_of) == len(TOPS):
        checkers = {folder / x: (HERE / "benchmark" / x).read_text() for x in CHECKERS}
        texts = {folder / DATA: data(values_of), folder / PAGE: page()}
        yield from write(checkers | texts)


def data(values_of: dict[Top, CertifiedValues]) -> str:
    """Exact data of all tops as JSON: the numbers of the scene's file, and all as decimals."""
    tops = [
        {
            "name": top.name,
            "about": top.about,
            "case": top.case,
            "exact": _written(top.case),
            "decimal": _decimals(values.scene),
            "attitude": values.rows[0][6:],
            "times": values.times[1:],
            "places": dict(zip(("omega", "gamma and attitude"), values.places, strict=True)),
            "values": f"{top.name}.csv",
            "certificate": top.proof,
        }
        for top, values in values_of.items()
    ]
    return json.dumps({"name": NAME, "version": VERSION, "tops": tops}, indent=1) + "\n"


def _written(case: str) -> dict[str, object]:
    """Body and start as the scene's file has them, numbers as texts."""
    numbers = tomllib.loads(polhode.load(case).source, parse_float=str)
    return {part: numbers[part] for part in ("body", "start")}


def _decimals(scene: polhode.Scene) -> dict[str, object]:
    body, gamma = scene.body, scene.gamma
    assert gamma is not None
    rows = {"moments": body.moments, "centre": body.centre, "omega": scene.omega, "gamma": gamma}
    decimals = {key: [_data_decimal(x) for x in row] for key, row in rows.items()}
    return {"weight": _data_decimal(body.weight), **decimals}


def _data_decimal(x: Any) -> str:
    """In full where that is short, else to 60 digits."""
    text = polhode.as_decimal(x, _PLACES)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def page() -> str:
    """What the folder is, and how it is used, in Markdown."""
    rows = [
        f"| [{top.name}]({top.name}.csv) | {top.about} | {top.times[-1]} | [proof]({top.proof}) |"
        for top in TOPS
    ]
    numbers = {"version": VERSION, "count": len(TOPS), "digits": DIGITS}
    lines = {"columns": ",".join(COLUMNS), "rows": "\n".join(rows)}
    return template("benchmark").format(**numbers, **lines)
