"""Labels beside curves, looks of methods, strips of dots."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from polhode.figures.canvas import dot_strips
from polhode.figures.canvas.canvas import COLOURS, as_svg, pyplot
from polhode.figures.canvas.direct_labels import LOOKS, End, _apart, ink, label_ends
from polhode.studies.long_run import rows as long_run
from polhode.studies.speed import contenders
from polhode.studies.speed.programs import OURS, PROGRAMS

DRAWN = [p.name for p in PROGRAMS if p.last and p.name != OURS]


@given(st.lists(st.floats(0, 1), min_size=1, max_size=9), st.floats(0.01, 0.1))
def test_labels_stand_apart_in_order_near_their_ends(wanted, least):
    wanted = sorted(wanted)
    found = _apart(wanted, least)
    gaps = [b - a for a, b in pairwise(found)]
    assert all(gap >= least - 1e-9 for gap in gaps)
    assert found[0] >= -1e-9
    assert found[-1] <= 1 + 1e-9
    if all(b - a > least for a, b in pairwise(wanted)):
        assert found == pytest.approx(wanted)


def test_labels_that_cannot_fit_are_centred():
    assert _apart([0.5] * 3, 1.0) == pytest.approx([-0.5, 0.5, 1.5])


def test_every_method_has_a_look_and_no_two_the_same():
    types = {m.name for m in contenders.OURS}
    assert {*types, *DRAWN, long_run.PLAIN, long_run.PROJECTED} <= LOOKS.keys()
    for names in (types, DRAWN):
        assert len({LOOKS[name] for name in names}) == len(names)


def test_a_colour_is_a_programs_or_a_number_types():
    """No other program has a colour of polhode's number types, or of another program."""
    programs: dict[str, set[str]] = {}
    for name in DRAWN:
        if not name.startswith("polhode"):
            programs.setdefault(LOOKS[name].colour, set()).add(name.split()[0])
    assert all(len(names) == 1 for names in programs.values())
    assert programs.keys().isdisjoint(COLOURS.values())


def test_the_label_is_drawn_with_its_name():
    plt = pyplot()
    with plt.rc_context({"svg.fonttype": "none"}):
        figure, axes = plt.subplots()
        axes.plot([1, 2], [1, 2])
        label_ends(axes, [End(2, 2, "a curve", "#0072b2"), End(2, 2, "another", "#d55e00")])
        text = as_svg(figure)
    assert "a curve" in text
    assert "another" in text
    assert ink("#0072b2") in text


def test_a_dot_behind_what_is_expected_has_a_ring():
    run = {"number": "quad", "correct_digits": 30.0, "expected": [31.0, 32.0, 33.0]}
    dot = dot_strips.dot(run)
    assert dot is not None
    assert (dot.digits, dot.number, dot.behind) == (30.0, "quad", True)
    enough = dot_strips.dot(run | {"correct_digits": 31.5})
    assert enough is not None
    assert not enough.behind
    assert dot_strips.dot({"number": "quad", "outcome": "step limit"}) is None
    drawn = dot_strips.svg({"one": [dot], "two": []}, "digits")
    assert "stroke-width: 0.9" in drawn
    assert drawn == dot_strips.svg({"one": [dot], "two": []}, "digits")
    assert "stroke-width: 0.9" not in dot_strips.svg({"one": [enough], "two": []}, "digits")
