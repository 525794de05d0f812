"""Certificates of chaos: the one that ships is proved, and no false one is."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat, ctx

from polhode.certificates import verify
from polhode.cli import main
from polhode.enclosures.fixed_point_problem import Refused
from polhode.proofs.chaos import covering, transit
from polhode.proofs.chaos.h_set import Chart, HSet
from polhode.scenes import library

Held = dict[str, Any]
FILE = library.folder() / "certificates" / "chaos.json"
SCALE = 2**120


@pytest.fixture
def held() -> Held:
    return json.loads(FILE.read_text())


def sizes(held: Held, n: int, **by: float) -> None:
    """Sizes of a set times numbers."""
    for name, factor in by.items():
        held["sets"][n][name] = int(held["sets"][n][name] * factor)


def meeting(held: Held) -> None:
    held["sets"][1]["middle"] = held["sets"][0]["middle"]


def other_chart(held: Held) -> None:
    held["charts"].append(copy.deepcopy(held["charts"][0]))
    held["sets"][1]["chart"] = len(held["charts"]) - 1


def off_centre(held: Held) -> None:
    """By three times the set's width."""
    held["charts"][0]["centre"][1][0] += 3 * held["sets"][0]["width"]


def shallow(held: Held) -> None:
    held["charts"][0]["eta"] = [[SCALE // 10**14]]


def level(held: Held) -> None:
    held["scene"]["level"][0] = "131/100"


def body(held: Held) -> None:
    held["scene"]["moments"][0] = "2.1"


def plane(held: Held) -> None:
    held["charts"][held["sets"][2]["chart"]]["plane"] = [[0]] * 6


def flat(held: Held) -> None:
    """K without a fourth direction."""
    for row in held["charts"][0]["deep"]:
        row[3] = row[2]


def late(held: Held) -> None:
    held["transits"][0]["grid"][-1] += 2**58  # 1/64


def backward(held: Held) -> None:
    held["transits"][0]["grid"] = [-t for t in held["transits"][0]["grid"]]


def reordered(held: Held) -> None:
    held["sets"][2:4] = held["sets"][3:1:-1]


#: What is done to the certificate, and what the checker says of it.
FALSE: list[tuple[Callable[[Held], None], str]] = [
    (meeting, "the first two sets may meet"),
    (other_chart, "not of one section map"),
    (off_centre, "over set|graph|plane"),
    (shallow, "no graph over its rectangle"),
    (level, "no graph over its rectangle"),
    (body, "no graph over its rectangle"),
    (flat, "touch the level"),
    (plane, "touch the|a chart is singular"),
    (late, "miss the next plane|over set"),
    (backward, "a time that is positive"),
    (reordered, "over set|miss|plane"),
    (lambda held: sizes(held, 1, height=0.05), "set 0 over set 1: the image is too high"),
    (lambda held: sizes(held, 1, width=8, middle=8), "set 0 over set 1: the image ends in the"),
    (lambda held: sizes(held, 0, width=0.1), "set 0 over set"),
]


@pytest.mark.sample(9)
@pytest.mark.parametrize(("change", "said"), FALSE, ids=range(len(FALSE)))
def test_a_false_certificate_is_not_proved(held, change, said):
    change(held)
    with pytest.raises((verify.NotProved, verify.Damaged), match=said):
        verify.verify(json.dumps(held).encode())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("entropy", "0.03", "the entropy is not shown to be as large"),
        ("long", "80.1", "the long loop may take longer"),
    ],
)
def test_a_statement_of_more_is_not_proved(held, name, value, said):
    held["statement"][name] = value
    with pytest.raises(verify.NotProved, match=said):
        verify.verify(json.dumps(held).encode())


#: A key, what stands there, and what is said.
DAMAGED = [
    ("sets", [], "expected"),
    ("charts", [], "chart"),
    ("transits", [], "transits"),
    ("scale", 0, "scale"),
    ("scale", 10**9, "scale"),
    ("bits", 10**9, "bits"),
    ("statement", {"entropy": "-1", "short": "1", "long": "1"}, "above 0"),
    ("statement", {"entropy": "1"}, "statement"),
]


@pytest.mark.parametrize(("key", "value", "said"), DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_certificate_is_none(held, key, value, said):
    held[key] = value
    with pytest.raises(verify.Damaged, match=said):
        verify.verify(json.dumps(held).encode())


def test_sets_of_no_size_and_charts_that_are_not_there_are_refused(held):
    for name, value in (("width", 0), ("height", -1), ("chart", 99)):
        bad = copy.deepcopy(held)
        bad["sets"][3][name] = value
        with pytest.raises(verify.Damaged):
            verify.verify(json.dumps(bad).encode())


def test_more_steps_than_can_be_checked_are_refused_at_once(held):
    held["bits"] = 4000
    with pytest.raises(verify.Damaged, match="are too many"):
        verify.verify(json.dumps(held).encode())


# -- one covering ---------------------------------------------------------------------------------


PROVERS = (verify, covering)  # the checker, and the proof that the certificate is of
CHART = Chart(92, (0,) * 6, np.zeros((6, 2)), np.zeros((6, 4)), np.zeros(6), 1.0)


def covers(
    prover: ModuleType, size=(1.0, 1.0), middle=0.0, chart=CHART, slope=None, **given: float
) -> Any:
    """An affine image of a set of sizes 1, made up, over a set with these."""
    x = {"stretch": 2.0, "height": 0.5, "depth": 0.1, "shift": 0.0, "up": 0.0}
    x |= {"bend": 0.0, "turn": 0.0} | given
    columns = [
        [arb(x["stretch"]), arb(x["turn"]), *[arb(0)] * 4],
        [arb(x["bend"]), arb(x["height"]), *[arb(0)] * 4],
        [arb(0), arb(0), *[arb(x["depth"])] * 4],
    ]
    off = [arb(x["shift"]), arb(x["up"]), *[arb(0)] * 4]
    slope = slope or [[x["stretch"], x["bend"]], [x["turn"], x["height"]]]
    derivative = arb_mat([[arb(y) for y in row] for row in slope])
    with ctx.workprec(64):
        if prover is verify:
            one = verify.Rectangle(0, arb(0), arb(1), arb(1))
            other = verify.Rectangle(0, arb(middle), arb(size[0]), arb(size[1]))
            what = verify.Image(off, columns, derivative, arb(1))
            return verify.covers(what, one, other, arb(1), "one over another")
        turn = arb_mat([list(row) for row in zip(*columns, strict=True)])
        source = HSet(CHART, 0.0, 1.0, 1.0)
        shift = arb_mat([[y] for y in off])
        what = transit.Image(source, CHART, shift, turn, derivative, arb(1), arb(2))
        return covering.covers(what, HSet(chart, middle, *size))


@pytest.mark.parametrize("prover", PROVERS)
def test_an_affine_covering_is_one_either_way_round(prover):
    for given in (
        {},
        {"stretch": -2.0},  # which exchanges the edges
        {"turn": 0.2, "bend": 0.3},
        {"slope": [[2.0, 0.5], [0.0, 0.9]]},
        {"size": (1.4, 0.6), "middle": 0.5},
    ):
        covers(prover, **given)


def test_the_margins_of_a_covering():
    found = covers(covering, size=(1.4, 0.6), middle=0.5, stretch=-2.0, depth=0.0)
    assert found.stretch == pytest.approx(1.5 / 1.4)
    assert found.height == pytest.approx(0.5 / 0.6)
    assert found.depth == 0.0
    assert covers(covering).cone == (4.0 - 1.0) * (1.0 - 0.25)
    with pytest.raises(Refused, match="charts"):
        covers(covering, chart=replace(CHART))


NAN = float("nan")
HIGH, SHORT, SHEET = "too high|is higher", "ends in the set|does not reach", "another sheet"


@pytest.mark.parametrize("prover", PROVERS)
@pytest.mark.parametrize(
    ("given", "said"),
    [
        *(({"height": x}, HIGH) for x in (1.0, NAN)),
        ({"up": 0.5}, HIGH),
        ({"turn": 0.6}, HIGH),
        *(({"depth": x}, SHEET) for x in (1.0, NAN)),
        *(({"stretch": x}, SHORT) for x in (1.0, -1.0, NAN)),
        # one edge is not beyond; both edges lie on one side
        *(({"shift": x}, SHORT) for x in (1.0, 1.5, 4.0, NAN)),
        ({"bend": 1.0}, SHORT),
        ({"size": (1.6, 0.6), "middle": 0.5}, SHORT),
        ({"stretch": 1.2, "turn": 0.8, "height": 0.1, "bend": 0.1}, "cone"),
        *(
            ({"slope": slope}, "cone")
            for slope in (
                [[1.0, 0.0], [0.0, 0.5]],
                [[2.0, 0.0], [0.0, 1.0]],
                [[2.0, 0.0], [2.0, 0.5]],
                [[0.5, 2.0], [0.0, 0.5]],
                [[2.0, 0.0], [1.2, 0.9]],
                [[0.5, 0.0], [0.0, 2.0]],
                [[NAN, 0.0], [0.0, 0.5]],
            )
        ),
    ],
)
def test_what_is_no_covering_is_refused(prover, given, said):
    with pytest.raises((verify.NotProved, Refused), match=said):
        covers(prover, **given)


# -- doors ----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_writes_a_certificate_that_another_program_proves(tmp_path, capsys):
    path = tmp_path / "chaos.json"
    scene = "general/asymmetric-chaotic"
    assert main(["prove", "chaos", scene, "-o", str(path)]) == 0
    assert f"certificate in {path}" in capsys.readouterr().err
    assert main(["verify", str(path)]) == 0
    out = capsys.readouterr().out
    assert "has a transversal homoclinic orbit" in out
    assert "by 20 covering relations with cone conditions between 19 sets" in out


def test_a_place_that_cannot_be_written_to_is_refused_before_the_proof(tmp_path, capsys):
    scene = "general/asymmetric-chaotic"
    assert main(["prove", "chaos", scene, "-o", str(tmp_path / "none" / "x.json")]) == 2
    assert main(["prove", "chaos", scene, "-o", str(tmp_path / "x.txt")]) == 2
    assert "ends in .json" in capsys.readouterr().err
