"""Write the certificates of cases/certificates: python tests/measure/certificates.py [NAME...].

Ten examples for ``polhode verify``, of states and of periodic orbits.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import polhode
from polhode.scenes import library

FOLDER = library.folder() / "certificates"


def _states(case: str, at: list[object], digits: int) -> Callable[[Path], None]:
    return lambda path: polhode.certify(case, at=at, digits=digits).save(path)


def _orbit(case: str, digits: int = 30) -> Callable[[Path], None]:
    return lambda path: polhode.prove_orbit(case, digits=digits).save(path)


def _found(case: str, k: int) -> Callable[[Path], None]:
    """The k-th orbit of a search."""

    def write(path: Path) -> None:
        from polhode.proofs.prove_orbit import prove_found

        found = polhode.orbit_search(case, (10, 10))
        prove_found(found, k - 1).save(path)

    return write


MADE = {
    "asymmetric-30-digits": _states("general/asymmetric-regular", [1, 10, "100/3"], 30),
    "chaotic": _states("general/asymmetric-chaotic", [10, 20, 30], 16),
    "dzhanibekov": _states("euler/dzhanibekov", [5, 10], 16),
    "kovalevskaya-backward": _states("kovalevskaya/generic", [-1, -4], 40),
    "irrational": _states("euler/irrational", [1, 2], 20),
    "turned-axes": _states("lagrange/turned-axes", [1, 3], 20),
    "grioli": _orbit("grioli/precession"),
    "grioli-turned-axes": _orbit("grioli/turned-axes", 16),
    "elliptic": _found("general/asymmetric-chaotic", 1),
    "hyperbolic": _found("general/asymmetric-chaotic", 2),
}

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or MADE:
        MADE[name](FOLDER / f"{name}.json")
