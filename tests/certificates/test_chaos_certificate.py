"""Certificates of chaos: the one that ships is proved, and no false one is."""

import copy
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from flint import arb, arb_mat, ctx

from polhode.certificates import verify
from shared.tools import altered, answer, tiers

Held = dict[str, Any]
FILE = Path(__file__).parents[2] / "cases" / "certificates" / "chaos.json"
SCALE = 2**120


HELD: Held = json.loads(FILE.read_text())
WIDTH, NEXT = (HELD["sets"][k]["width"] for k in range(2))


@pytest.fixture
def certificate() -> Held:
    return copy.deepcopy(HELD)


def times(by: float) -> Callable[[int], int]:
    return lambda x: int(x * by)


HOME = copy.deepcopy(HELD["charts"][0])
GRAPH, LIES = "no graph over its rectangle", "over set|graph|plane"
#: Places of the certificate, what stands there then or is made of it, and what is said.
FALSE: list[tuple[dict[str, Any], str]] = [
    ({"sets 1 middle": HELD["sets"][0]["middle"]}, "the first two sets may meet"),
    # they meet, though the one's middle is outside of the other
    ({"sets 1 middle": WIDTH // 2 + NEXT}, "the first two sets may meet"),
    ({"sets 1 middle": WIDTH + NEXT // 2}, "the first two sets may meet"),
    (
        {"charts": lambda x: [*x, HOME], "sets 1 chart": len(HELD["charts"])},
        "not of one section map",
    ),
    ({"charts 0 centre 1 0": lambda x: x + 3 * WIDTH}, LIES),
    ({"charts 0 eta": [[SCALE // 10**14]]}, GRAPH),
    ({"scene level 0": "131/100"}, GRAPH),
    ({"scene moments 0": "2.1"}, GRAPH),
    # K without a fourth direction
    ({"charts 0 deep": lambda x: [[*row[:3], row[2]] for row in x]}, "touch the level"),
    ({f"charts {HELD['sets'][2]['chart']} plane": [[0]] * 6}, "touch the|a chart is singular"),
    ({"transits 0 grid": lambda x: [*x[:-1], x[-1] + 2**58]}, "miss the next plane|over set"),
    ({"transits 0 grid": lambda x: [-t for t in x]}, "a time that is positive"),
    ({"sets": lambda x: [*x[:2], x[3], x[2], *x[4:]]}, "over set|miss|plane"),
    ({"sets 1 height": times(0.05)}, "set 0 over set 1: the image is too high"),
    (
        {"sets 1 width": times(8), "sets 1 middle": times(8)},
        "set 0 over set 1: the image ends in the",
    ),
    ({"sets 0 width": times(0.1)}, "set 0 over set"),
]


@pytest.mark.parametrize(("changes", "said"), tiers(FALSE[:7], FALSE[7:]))
def test_a_false_certificate_is_not_proved(certificate, changes, said):
    for place, value in changes.items():
        certificate = altered(certificate, place, value)
    text = answer(certificate)
    assert text.startswith("refused: ")
    assert re.search(said, text)


@pytest.mark.slow
def test_what_ships_is_proved_and_a_statement_of_more_is_not(certificate, monkeypatch):
    """The sets' images are those of the proof each time: no statement changes them."""
    honest, images = verify._image, []
    monkeypatch.setattr(
        verify, "_image", lambda *arguments: images.append(honest(*arguments)) or images[-1]
    )
    proved = verify.verify(FILE.read_bytes())
    assert "the topological entropy of the motion on the level is at least" in proved[1]
    more = {
        ("entropy", "0.03"): "the entropy is not shown to be as large",
        ("short", "1"): "the short loop may take longer",
        ("long", "80.1"): "the long loop may take longer",
    }
    for (name, value), said in more.items():
        again = iter(images)
        monkeypatch.setattr(verify, "_image", lambda *_, again=again: next(again))
        arguments = altered(certificate, f"statement {name}", value)
        with pytest.raises(verify.NotProved, match=said):
            verify.verify(json.dumps(arguments).encode())


#: A place, what stands there, and what is said.
DAMAGED = [
    ("sets", [], "expected"),
    ("sets 3 width", 0, "sizes above 0"),
    ("sets 3 height", -1, "sizes above 0"),
    ("sets 3 chart", 99, "chart"),
    ("charts", [], "chart"),
    ("transits", [], "transits"),
    ("scale", 0, "scale"),
    ("scale", 10**9, "scale"),
    ("bits", 10**9, "bits"),
    ("bits", 4000, "are too many"),  # more steps than can be checked
    ("statement", {"entropy": "-1", "short": "1", "long": "1"}, "above 0"),
    ("statement", {"entropy": "1"}, "statement"),
]


@pytest.mark.parametrize(("place", "value", "said"), DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_certificate_is_none(certificate, place, value, said):
    text = answer(altered(certificate, place, value))
    assert "no certificate" in text or "expected one of polhode's" in text
    assert said in text


# -- one covering ---------------------------------------------------------------------------------


def covers(
    size=(1.0, 1.0), middle=0.0, slope=None, source=(1.0, 1.0), **more: float
) -> verify.Margins:
    """An affine image, made up, of a set of the sizes ``source``, over a set with these."""
    x = {"stretch": 2.0, "height": 0.5, "depth": 0.1, "shift": 0.0, "up": 0.0, "last": 0.0}
    x |= {"bend": 0.0, "turn": 0.0} | more
    columns = [
        [arb(x["stretch"]), arb(x["turn"]), *[arb(0)] * 4],
        [arb(x["bend"]), arb(x["height"]), *[arb(0)] * 4],
        [arb(0), arb(0), *[arb(x["depth"])] * 4],
    ]
    off = [arb(x["shift"]), arb(x["up"]), *[arb(0)] * 3, arb(x["last"])]
    slope = slope or [[x["stretch"], x["bend"]], [x["turn"], x["height"]]]
    derivative = arb_mat([[arb(y) for y in row] for row in slope])
    with ctx.workprec(64):
        home = verify.Rectangle(0, arb(0), arb(source[0]), arb(source[1]))
        target = verify.Rectangle(0, arb(middle), arb(size[0]), arb(size[1]))
        image = verify.Image(off, columns, derivative, arb(1), arb(2))
        return verify.covers(image, home, target, arb(1), "one over another")


def test_an_affine_covering_is_one_either_way_round_with_its_margins():
    for options in (
        {},
        {"stretch": -2.0},  # which exchanges the edges
        {"turn": 0.2, "bend": 0.3},
        {"slope": [[2.0, 0.5], [0.0, 0.9]]},
        {"size": (1.4, 0.6), "middle": 0.5},
    ):
        covers(**options)
    margins = covers(size=(1.4, 0.6), middle=0.5, stretch=-2.0, depth=0.0)
    assert float(margins.stretch) == pytest.approx(1.5 / 1.4)
    assert float(margins.height) == pytest.approx(0.5 / 0.6)
    assert float(margins.cone) == pytest.approx(((2 / 1.4) ** 2 - 1) * (1 - (0.5 / 0.6) ** 2))
    assert float(covers().cone) == (4.0 - 1.0) * (1.0 - 0.25)
    assert float(covers(source=(0.75, 0.5)).cone) == (2.25 - 1.0) * (1.0 - 0.0625)


NAN = float("nan")
HIGH, SHORT, SHEET = "too high", "ends in the set", "another sheet"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        *(({"height": x}, HIGH) for x in (1.0, NAN)),
        ({"up": 0.5}, HIGH),
        ({"turn": 0.6}, HIGH),
        *(({"depth": x}, SHEET) for x in (1.0, NAN)),
        *(({"last": x}, SHEET) for x in (0.95, -0.95)),  # of four depths one
        *(({"stretch": x}, SHORT) for x in (1.0, -1.0, NAN)),
        # one edge is not beyond; both edges lie on one side
        *(({"shift": x}, SHORT) for x in (1.0, 1.5, 4.0, NAN)),
        ({"bend": 1.0}, SHORT),
        ({"size": (1.6, 0.6), "middle": 0.5}, SHORT),
        ({"source": (0.5, 1.0)}, "cone"),
        ({"source": (1.0, 2.0)}, "cone"),
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
def test_what_is_no_covering_is_refused(options, said):
    with pytest.raises(verify.NotProved, match=said):
        covers(**options)


def test_a_plane_that_is_too_far_for_the_span_is_missed():
    """Of some distances only this refuses: the speed across the plane may fall below 2/3 of it."""
    with ctx.workprec(128):
        inertia = [[arb(2), arb(0), arb(0)], [arb(0), arb(3) / 2, arb(0)], [arb(0), arb(0), arb(1)]]
        body = verify.Body(inertia, [arb(1) / 3, arb(1) / 5, arb(1) / 2])
        box = [arb(1) / 3, arb(1) / 5, arb(1), arb(3) / 5, arb(0), arb(4) / 5]
        plane = [arb(int(k == 3)) for k in range(6)]
        for steps, said in ((24, "may touch"), (28, "may miss"), (29, "may miss")):
            with pytest.raises(verify.NotProved, match=said):
                verify._crossing(body, plane, box, (arb(2) ** (arb(-steps) / 4)).mid())
        span, reached = verify._crossing(body, plane, box, arb(2) ** -12)
        speed = verify.rates(body, reached)[3].abs_lower()
        assert arb(2) ** -12 < speed * span < arb(2) ** -11


# -- doors ----------------------------------------------------------------------------------------


def test_a_place_that_cannot_be_written_to_is_refused_before_the_proof(refusal):
    for place, said in (("none/x.json", "existing folder"), ("x.txt", "ends in ")):
        assert said in refusal("prove", "chaos", "general/asymmetric-chaotic", "-o", place)
