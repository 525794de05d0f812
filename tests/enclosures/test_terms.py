"""Every term of the proof alone, and the proof with that term dropped: the drop must show."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import Any

import pytest

from polhode.enclosures import integral_contraction, step_bound, zonotope
from shared import enclosures as terms
from shared.tools import tiers, without

#: The term, the motion that shows it, and how the term is dropped: module, function, old, new.
DROPPED: list[tuple[str, Callable[[], list[float]], tuple[Any, str, str, str]]] = [
    ("residual", terms.residual, (step_bound, "_delta", "UP * (total +", "UP * (0.0 * total +")),
    ("jump", terms.jumps, (zonotope, "_Carried.step", "(jump + gamma(7) * hull)", "hull * 1e-16")),
    ("start", terms.start_box, (zonotope, "beginning", "np.diag(problem.spread)", "np.eye(6)")),
    (
        "start's columns",
        terms.start_box,
        (zonotope, "_Carried.settle", "self.turn @ self.settled,", "0.0 * self.settled,"),
    ),
    (
        "h beta",
        terms.quadratic,
        (zonotope, "advance", "pieces.lengths * problem.beta", "0.0 * pieces.lengths"),
    ),
    ("s at an output", terms.quadratic, (zonotope, "_balls", "radii + step.s", "radii")),
    ("s in the chain", terms.residual, (zonotope, "_Carried.step", "UP * (s +", "UP * (0.0 +")),
    (
        "columns born at an output",
        terms.residual,
        (zonotope, "_balls", "carried.born[:, : carried.count]", "carried.born[:, :0]"),
    ),
    (
        "columns born when settled",
        terms.residual,
        (zonotope, "_Carried.settle", "self.born[:, : self.count]", "self.born[:, :0]"),
    ),
    (
        "jump at an output",
        terms.jumps,
        (zonotope, "_balls", "(jump + gamma(16) * hull)", "(gamma(16) * hull)"),
    ),
    (
        "end of a window",
        terms.rounding,
        (zonotope, "advance", "carried.settle(rest)", "carried.settle(0.0)"),
    ),
    (
        "curvature of an integral",
        terms.integrals,
        (integral_contraction, "_measured", "0.5 * eps * curved", "0.0 * eps * curved"),
    ),
    ("w of an integral", terms.integrals, (integral_contraction, "shrunk", "size @ width +", "")),
]


@pytest.mark.parametrize(
    "motion", tiers(["integrals", "jumps", "residual", "rounding"], ["quadratic", "start_box"])
)
def test_one_term_alone_is_enough_and_not_slack(motion: str) -> None:
    ratio = getattr(terms, motion)()
    assert max(ratio) <= 1.0
    assert max(ratio) >= 1e-3
    assert statistics.median(ratio) >= (0.3 if motion == "start_box" else 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("term", [row[0] for row in DROPPED])
def test_a_dropped_term_is_noticed(term: str) -> None:
    _, motion, change = next(row for row in DROPPED if row[0] == term)
    with without(*change):
        try:
            ratio = motion()
        except integral_contraction.Contradiction:
            return
    assert max(ratio) > 1.0
