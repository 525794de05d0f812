"""The study of certified digits: what it says follows from its rows."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

import polhode
from polhode.studies import report
from polhode.studies.certified import page, rows

CONTAINED = {
    "case": "a",
    "reference": "euler",
    "end": 2.0,
    "ratio": 0.5,
    "inside": True,
    "digits": 17.0,
    "tries": 1,
}
GROWTH = {"case": "a", "times": [1, 2], "noise": 66, "digits": [1.0], "lost": [1.0, 2.0]}


def _found(inside: bool = True, without: float = 2.0, proof: float = 2.0) -> dict[str, Any]:
    return {
        "study": "certified",
        "contained": [CONTAINED, CONTAINED | {"case": "b", "inside": inside, "tries": 2}],
        "growth": [GROWTH | {"lost_without": [1.0, without]}],
        "cost": [
            {
                **{"case": "a", "digits": 16, "end": 5, "proven": 17.0, "noise": 66, "tries": 1},
                "trials": 5,
                "seconds": {"proof": proof, "mp, 66 bits": 1.0, "double": 0.1},
            }
        ],
        "judged": [{"case": "a", "t": 1, "column": "p", "error": "1e-16", "uncertainty": "1e-22"}],
    }


def _text(found: dict[str, Any]) -> str:
    return report.markdown("title", page.blocks(found))


def test_sentences_follow_the_rows() -> None:
    assert "All 2 closed forms lie in their enclosures" in _text(_found())
    assert "1 of 2 closed forms lie OUTSIDE: b" in _text(_found(inside=False))
    assert "save up to 0.0 digits, in some cases almost none" in _text(_found())
    assert "save between 3.0 and 3.0 digits" in _text(_found(without=5.0))
    assert "takes 2.0 to 2.0 times as long as the mp run" in _text(_found())
    assert "takes 7.0 to 7.0 times as long as the mp run" in _text(_found(proof=7.0))
    assert "in 1 of 2 the first choice of precision" in _text(_found())


def test_a_run_that_is_lost_in_the_noise_of_building_has_no_seconds() -> None:
    """Noise was printed: 1e-06 s, and "a proof takes 149000 times the mp run"."""
    found = _found()
    del found["cost"][0]["seconds"]["mp, 66 bits"]
    text = _text(found)
    assert "| 2 | – | – | – | 0.1 | – | – |" in text
    assert "as long as the mp run" not in text
    assert "a proof takes" not in page.finding(found)


def test_seconds_are_those_of_the_way_alone() -> None:
    row = rows._cost("lagrange/nutation", 16, 5)
    assert rows.LEAST_TRIALS <= row["trials"] <= rows.COST_TRIALS
    assert 1e-6 < row["seconds"].get("double", 1e-5) < row["seconds"]["proof"]
    assert all(seconds > 0 for seconds in row["seconds"].values())


def test_a_closed_form_beside_the_motion_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = replace(polhode.load("lagrange/nutation"), outputs=())
    assert rows.contained_in(scene)["inside"]
    omega = (scene.omega[0] + Fraction(1, 10**15), *scene.omega[1:])
    other = replace(scene, omega=omega)
    honest = rows.reference_of
    monkeypatch.setattr(rows, "reference_of", lambda _: honest(other))
    assert not rows.contained_in(scene)["inside"]


def test_an_error_in_double_is_larger_than_what_it_is_uncertain_by() -> None:
    for row in rows._judged("lagrange/nutation", (1, 5)):
        assert 1e-18 < float(row["error"]) < 1e-13
        assert float(row["uncertainty"]) < 1e-4 * float(row["error"])
