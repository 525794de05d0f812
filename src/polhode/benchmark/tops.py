"""The tops of the benchmark: which, why, and the times of their values."""

from __future__ import annotations

from typing import NamedTuple

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
