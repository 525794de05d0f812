"""The classical tops by mpmath's own functions, beside the closed forms in balls."""

from __future__ import annotations

import json

import mpmath
import pytest

import polhode
from polhode.cli import main

FAST = (
    *("euler/largest-axis", "euler/odd-order", "euler/turned-axes", "euler/separatrix-irrational"),
    *("euler/turned-symmetric", "euler/turned-permanent", "euler/rest", "euler/no-gamma"),
    *("euler/near-separatrix", "euler/huge-units", "hard/dzhanibekov-1e-12"),
    *("lagrange/nutation", "lagrange/cusped", "lagrange/turned-axes", "lagrange/second-axis"),
    *("lagrange/negative-weight", "lagrange/spherical-body", "hard/near-pole", "hard/near-cusp"),
    *("lagrange/steady-slow", "hard/near-steady"),
)
KOVALEVSKAYA = (
    *("anchor", "from-a-branch-point", "generic", "irrational-centre", "type-e-ee"),
    *("type-e-minus", "type-ee-e", "type-eee-inside", "type-eee-outside"),
)
SLOW = [pytest.param(f"kovalevskaya/{name}", 20, marks=[pytest.mark.slow]) for name in KOVALEVSKAYA]


def distance(case: str, t: str, digits: int) -> mpmath.mpf:
    """Of w over its size, or of gamma, between the two references."""
    witness = polhode.reference(case, backend="mpmath")
    (row,), (ours,) = (
        top.at([t], digits=digits + more)
        for top, more in ((witness, 0), (polhode.reference(case), 5))
    )
    size = mpmath.norm(ours[:3]) or 1
    return max(
        abs(x - y) / (size if k < 3 else 1) for k, (x, y) in enumerate(zip(row, ours, strict=True))
    )


@pytest.mark.parametrize(("case", "digits"), [*((name, 30) for name in FAST), *SLOW])
@pytest.mark.parametrize("t", ["7", "-1/3"])
def test_two_references_that_share_nothing_agree(case: str, digits: int, t: str) -> None:
    assert distance(case, t, digits) < mpmath.mpf(10) ** -digits


def test_a_generic_motion_of_kovalevskaya() -> None:
    assert distance("kovalevskaya/type-ee-e", "2", 15) < 1e-15


def test_more_digits_are_more_digits() -> None:
    near, far = (distance("lagrange/looping", "7", digits) for digits in (10, 60))
    assert far < mpmath.mpf(10) ** -60
    assert mpmath.mpf(10) ** -30 < near < mpmath.mpf(10) ** -10  # rounded to what was asked


@pytest.mark.slow
def test_signs_next_to_a_double_point_are_read_at_the_start() -> None:
    """Read a moment later they were wrong, and two precisions agreed on 20 digits."""
    assert distance("kovalevskaya/near-delaunay", "7", 30) < mpmath.mpf(10) ** -30


REFUSED = {
    "another backend": ("euler/rest", "sympy", "backend = sympy: expected flint or mpmath"),
    "another family": ("grioli/precession", "mpmath", "euler, lagrange or kovalevskaya"),
    "no family": ("general/asymmetric-regular", "mpmath", "euler, lagrange or kovalevskaya"),
    "a special motion": ("kovalevskaya/delaunay", "mpmath", "Delaunay: expected a generic motion"),
    "a pole": ("lagrange/upper-pole", "mpmath", "through a pole"),
}


@pytest.mark.parametrize("row", REFUSED.values(), ids=REFUSED)
def test_what_it_does_not_have_is_refused_in_a_line(
    row: tuple[str, str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    case, backend, words = row
    assert main(["reference", case, "--at", "1", "--outputs", "", "--backend", backend]) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert words in shown.err


def test_the_command_says_that_its_digits_are_not_proven(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["reference", "euler/attitude", "--at", "1", "--digits", "25", "--json"]
    assert main([*words, "--backend", "mpmath"]) == 0
    shown = capsys.readouterr()
    witness, ours = json.loads(shown.out), None
    assert "states alone" in shown.err
    assert main(words) == 0
    ours = json.loads(capsys.readouterr().out)
    assert (witness["proven"], ours["proven"]) == (False, True)
    assert "radii" not in witness
    assert witness["states"] == ours["states"]
