"""What the answers say of their proof: in Python, in JSON, and in verdicts."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest
from flint import acb

import polhode
from polhode.closed_forms.kovalevskaya.theta_attitude import EigenspaceChoice, Moment
from polhode.scenes.vocabulary import STATE

IRRATIONAL = polhode.top(
    moments=("2*sqrt(2)*sqrt(3)", "2*sqrt(6)", "sqrt(6)"),
    centre=(1, 0, 0),
    weight=1,
    omega=(1, "1/2", "1/3"),
    gamma=("3/5", 0, "4/5"),
    end=1,
)
FORMULA = "states are proven; of the attitude the formula is checked"
ZERO = "if these numbers are 0: |x| < 1e-"
#: A scene, and what its reference says: yes, no, or words.
SAID: list[tuple[str | polhode.Scene, bool | tuple[str, ...]]] = [
    ("euler/largest-axis", True),
    ("euler/separatrix-irrational", (ZERO,)),
    ("kovalevskaya/delaunay", True),
    ("kovalevskaya/generic", (FORMULA,)),
    ("kovalevskaya/asymptotic", ("the attitude by an enclosure",)),
    ("bobylev-steklov/asymptotic", (ZERO,)),
    ("bobylev-steklov/cn", True),
    ("chaplygin/motion", (ZERO,)),
    ("grioli/precession", True),
    ("n-kowalewski/motion", (ZERO,)),
    ("staude/unstable", True),
    ("steklov/upper", (ZERO,)),
    ("hess/loxodrome", True),
    (IRRATIONAL, (FORMULA, ZERO)),
    ("goryachev-chaplygin/inner-band", ("the attitude by an enclosure",)),
]


@pytest.mark.sample(2, first=1, slow=2)
@pytest.mark.parametrize(
    ("scene", "said"), SAID, ids=[x if isinstance(x, str) else x.name for x, _ in SAID]
)
def test_a_verdict_says_what_is_proven_and_only_proofs_have_radii(
    scene: str | polhode.Scene, said: bool | tuple[str, ...]
) -> None:
    truth = polhode.reference(scene)
    assert isinstance(truth, polhode.Reference)
    rows = [[float(x) for x in row] for row in truth.at([1], 17)]
    judged = polhode.compare(rows, scene, at=[1])
    for answer in (truth.proven, judged.fact("assumed") or judged.fact("proven")):
        if isinstance(said, bool):
            assert answer is said
        else:
            assert isinstance(answer, str)
            assert all(words in answer for words in said)
            assert ("if these" in answer) is (ZERO in said)
    assert (truth.radii([1], 20) is None) is (said is False)


def test_radii_in_json_hold_what_printing_rounds_off() -> None:
    tables = [
        polhode.reference_table("kovalevskaya/generic", at=[1, 2, 3], digits=digits)
        for digits in (5, 40)
    ]
    few, many = (json.loads(table.to_json())["columns"] for table in tables)
    for name in STATE:
        for x, y, radius in zip(few[name], many[name], few[f"{name}_radius"], strict=True):
            assert abs(Fraction(x) - Fraction(y)) <= Fraction(radius) < Fraction(1, 10**4)


def test_an_attitude_is_answered_after_the_states_at_the_same_times() -> None:
    truth = polhode.reference("kovalevskaya/generic")
    truth.at([1], 20)
    assert [len(row) for row in truth.attitude([1], 20)] == [4]


def test_an_attitude_that_has_not_the_gamma_of_the_state_is_no_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = EigenspaceChoice.at

    def flipped(choice: EigenspaceChoice, moment: Moment) -> tuple[acb, acb]:
        xi, eta = right(choice, moment)
        return xi, -eta

    monkeypatch.setattr(EigenspaceChoice, "at", flipped)
    truth = polhode.reference("kovalevskaya/generic")
    with pytest.raises(polhode.BadInput, match="has not the gamma of the state"):
        truth.attitude([1], 20)
