"""The classical tops by mpmath's own functions, beside the closed forms in balls."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from itertools import cycle
from typing import Any

import mpmath
import pytest

import polhode
from polhode.cli import main
from shared.tools import tiers

KOVALEVSKAYA = (
    *("kovalevskaya/gamma-along-r0", "kovalevskaya/irrational-centre", "kovalevskaya/type-e-ee"),
    *("kovalevskaya/type-e-minus", "kovalevskaya/type-eee-inside"),
)


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


FAST = (
    *("euler/largest-axis", "euler/turned-permanent", "hard/dzhanibekov-1e-12"),
    "lagrange/negative-weight",
)
SLOW = "euler/odd-order", "euler/no-gamma", "lagrange/second-axis", *KOVALEVSKAYA
TIMES = "7", "-1/3"


@pytest.mark.parametrize(
    ("case", "t"),
    tiers(zip(FAST, cycle(TIMES), strict=False), zip(SLOW, cycle(TIMES), strict=False)),
)
def test_two_references_that_share_nothing_agree(case: str, t: str) -> None:
    assert distance(case, t, 30) < mpmath.mpf(10) ** -30


def test_a_generic_motion_of_kovalevskaya() -> None:
    assert distance("kovalevskaya/type-ee-e", "2", 15) < 1e-15


@pytest.mark.slow
def test_a_start_at_which_both_variables_turn() -> None:
    """r = 0 and gamma3 = 0: no sign can be read there."""
    body = polhode.Body.of_moments((2, 2, 1), (1, 0, 0), 1)
    scene = polhode.Scene(body, ("3/10", "-7/5", 0), ("3/5", "4/5", 0))
    times = ["7", "-1/3"]
    rows = polhode.reference(scene, backend="mpmath").at(times, digits=25)
    for row, ours in zip(rows, polhode.reference(scene).at(times, digits=30), strict=True):
        assert max(abs(x - y) for x, y in zip(row, ours, strict=True)) < 1e-25


def test_more_digits_are_more_digits() -> None:
    near, far = (distance("lagrange/looping", "7", digits) for digits in (10, 60))
    assert far < mpmath.mpf(10) ** -60
    assert mpmath.mpf(10) ** -30 < near < mpmath.mpf(10) ** -10  # rounded to what was asked


@pytest.mark.slow
def test_signs_next_to_a_double_point_are_read_at_the_start() -> None:
    """Read a moment later they were wrong, and two precisions agreed on 20 digits."""
    assert distance("kovalevskaya/near-delaunay", "7", 30) < mpmath.mpf(10) ** -30


def at_1000(omega: Any, gamma: Any) -> mpmath.mpf:
    """The distance to 10 digits, of a free body that has 1, 5/2, 3 for moments."""
    body = polhode.Body.of_moments((1, "5/2", 3), (0, 0, 0), 0)
    scene = polhode.Scene(body, omega, gamma)
    witness = polhode.reference(scene, backend="mpmath")
    (row,), (ours,) = witness.at([1000], digits=10), polhode.reference(scene).at([1000], digits=20)
    return max(abs(x - y) for x, y in zip(row, ours, strict=True))


@pytest.mark.parametrize("gap", [0, Fraction(1, 10**90)])
def test_a_separatrix_and_what_is_next_to_it_long_after(gap: Fraction | int) -> None:
    """The amplitude told nothing any more, and two precisions agreed on the separatrix."""
    assert at_1000((1, 0, 1 + gap), ("3/5", 0, "4/5")) < 1e-10


def test_next_to_a_permanent_rotation_no_two_precisions_agree_on_it() -> None:
    with pytest.raises(ValueError, match=r"5 working precisions, next to a separatrix"):
        at_1000((Fraction(1, 10**90), 1, 0), ("3/5", 0, "4/5"))


def test_a_symmetric_body_almost_about_an_equatorial_axis_is_not_refused() -> None:
    """By 1e-32: the order of the axes was told by rounding, and 0 divided."""
    body = polhode.Body.of_moments((40, 36, 40), (0, 0, 0), 0)
    scene = polhode.Scene(
        body, (Fraction(1), Fraction(1, 10**32), Fraction(-4, 10**30)), ("3/5", 0, "4/5")
    )
    (row,) = polhode.reference(scene, backend="mpmath").at([7], digits=15)
    (ours,) = polhode.reference(scene).at([7], digits=20)
    assert max(abs(x - y) for x, y in zip(row, ours, strict=True)) < 1e-15


def test_three_roots_that_rounding_makes_a_pair_are_no_steady_precession() -> None:
    """Almost upright, by 1e-24 of the speed at which the sleeping top loses its stability."""
    body = polhode.Body.of_moments(("8/9", "8/9", "4/9"), (0, 0, "13/7"), 1)
    ten, size = 10**35, 10**70 + 19
    gamma = Fraction(-6 * ten - 6, size), Fraction(6 * ten - 6, size), Fraction(size - 36, size)
    scene = polhode.Scene(body, (0, 0, f"sqrt(234/7) * {1 + Fraction(1, 10**24)}"), gamma)
    with pytest.raises(ValueError, match=r"through a pole|three roots are equal"):
        polhode.reference(scene, backend="mpmath").at([10**6], digits=30)


REFUSED = {
    "another backend": ("euler/rest", "sympy", "backend = sympy: expected flint or mpmath"),
    "another family": ("grioli/precession", "mpmath", "euler, lagrange or kovalevskaya"),
    "no family": ("general/asymmetric-regular", "mpmath", "euler, lagrange or kovalevskaya"),
    "a special motion": ("kovalevskaya/delaunay", "mpmath", "Delaunay: expected a generic motion"),
    "a pole": ("lagrange/upper-pole", "mpmath", "through a pole"),
}


@pytest.mark.parametrize("row", REFUSED.values(), ids=REFUSED)
def test_what_it_does_not_have_is_refused_in_a_line(
    row: tuple[str, str, str], refusal: Callable[..., str]
) -> None:
    case, backend, words = row
    command = ["reference", case, "--at", "1", "--outputs", "", "--backend", backend]
    assert words in refusal(*command)


def test_the_command_says_that_its_digits_are_not_proven(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["reference", "euler/attitude", "--at", "1", "--digits", "25", "--json"]
    assert main([*words, "--backend", "mpmath"]) == 0
    shown = capsys.readouterr()
    witness, ours = json.loads(shown.out), None
    assert "states alone" in shown.err
    assert "the digits are reproduced, not proven" in shown.err
    assert main(words) == 0
    shown = capsys.readouterr()
    assert "not proven" not in shown.err
    ours = json.loads(shown.out)
    assert (witness["proven"], ours["proven"]) == (False, True)
    assert "p_radius" in ours["columns"]
    assert "p_radius" not in witness["columns"]
    assert {name: ours["columns"][name] for name in witness["columns"]} == witness["columns"]
