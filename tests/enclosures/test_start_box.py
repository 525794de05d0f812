"""All motions from a box of starts at once: the balls hold what single starts give, in quad."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import polhode
from polhode import BadInput, Outcome
from polhode.cli import main
from shared.tools import exactly, tiers

RADII = Fraction(1, 10**8), Fraction(3, 10**9), Fraction(1, 10**8)
SIDES = [*itertools.product((-1, 1), repeat=3), (Fraction(1, 3), Fraction(-2, 5), 0)]
DATA = Path(__file__).parents[1] / "data" / "tilted.toml"
TILTED = DATA.read_text(encoding="utf-8")
FILE = TILTED.replace('"1/3"', '"1/3 \u00b1 1e-8"').replace("0.4,", '"0.4 +- 2e-9",')
SCENES = {
    "tilted": polhode.load(DATA),
    **{
        name: polhode.load(name)
        for name in ("lagrange/nutation", "kovalevskaya/generic", "general/asymmetric-chaotic")
    },
}


def moved(scene, side):
    omega = [w + s * r for w, s, r in zip(scene.omega, side, RADII, strict=True)]
    return replace(scene, omega=tuple(omega), events=scene.events)


def reach(centres, radii, truth):
    """The largest |truth - centre|/radius of rows."""
    return max(
        float(abs(exactly(x) - c) / Fraction(r))
        for row, middle, wide in zip(truth, centres, radii, strict=True)
        for x, c, r in zip(row, middle, wide, strict=True)
    )


def farthest(scene, times, outputs=()):
    """Of the state and of an output: how far single starts come in their balls."""
    scene = replace(scene, outputs=outputs, events=())
    enclosure = polhode.certify(scene, times, omega_radius=RADII)
    assert enclosure.outcome.done
    parts = [(enclosure.centres, enclosure.radii, "states")]
    parts += [(*getattr(enclosure, word), word) for word in outputs]
    ratios = []
    for side in SIDES:
        run = polhode.integrate(moved(scene, side), "quad", at=times)
        ratios.append([reach(x, r, getattr(run, word)) for x, r, word in parts])
    return [max(column) for column in zip(*ratios, strict=True)]


@pytest.mark.parametrize("name", tiers(["general/asymmetric-chaotic"], ["tilted"]))
def test_every_start_of_the_box_is_in_the_balls_and_corners_come_near_their_edges(name):
    for ratio in farthest(SCENES[name], [Fraction(1, 2), 3], ("attitude", "angles")):
        assert 0.01 < ratio <= 1
    assert 0.5 < farthest(SCENES[name], [Fraction(1, 1000)])[0] <= 1
    assert 0.01 < farthest(SCENES[name], [-2])[0] <= 1
    start = polhode.certify(SCENES[name], [0], omega_radius=RADII)
    for wide, r in zip(start.radii[0], [*RADII, 0, 0, 0], strict=True):
        assert 0 <= wide - r <= (2e-8 if name == "tilted" else 1e-15)


# -- events -----------------------------------------------------------------------------------


def watched(scene, zero):
    return replace(scene, outputs=(), events=(polhode.Event("it", zero),))


@pytest.mark.slow
def test_an_event_is_one_of_every_start_and_the_state_then_is_in_its_balls():
    scene = watched(SCENES["tilted"], "gamma1 - gamma2/3")
    (events,) = polhode.certify_events(scene, 6, omega_radius=RADII)
    assert events.proven
    assert len(events.times) >= 2
    most = 0.0
    for side in SIDES:
        (event,) = polhode.integrate(moved(scene, side), "quad", at=[6]).events
        assert len(event.times) == len(events.times)
        for t, row, ball in zip(event.times, event.states, events.times, strict=True):
            assert abs(exactly(t) - ball.time) <= Fraction(ball.radius)
            most = max(most, reach([ball.state], [ball.radii], [row]))
    assert 0.05 < most <= 1


def test_an_event_at_the_start_s_middle_is_not_decided_for_a_box():
    scene = SCENES["kovalevskaya/generic"]
    scene = watched(scene, f"p - {scene.omega[0]}")
    (alone,) = polhode.certify_events(scene, 1)
    assert alone.proven
    (certified,) = polhode.certify_events(scene, 1, omega_radius="1e-6")
    assert certified.undecided[0][0] == 0


# -- as far as a box can be followed ----------------------------------------------------------


@pytest.mark.slow
def test_a_wide_box_is_followed_as_far_as_it_goes(tmp_path, capsys):
    scene = SCENES["general/asymmetric-chaotic"]
    enclosure = polhode.certify(scene, [1, 2, 500], omega_radius="1e-5")
    assert enclosure.outcome is Outcome.TOO_WIDE
    assert [*enclosure.times] == [1, 2]
    assert 8 < enclosure.until < 100
    assert not enclosure.complete
    path = tmp_path / "wide.toml"
    path.write_text(FILE.replace("1e-8", "1e-5").replace("end = 5", "at = [1, 500]"))
    assert main(["certify", str(path)]) == 3
    output = capsys.readouterr()
    assert "1 of 2 times: followed to t = " in output.err
    assert len(output.out.splitlines()) == 2


def test_times_before_0_are_not_reached_where_those_after_it_are_not():
    enclosure = polhode.certify("general/asymmetric-chaotic", at=[-1, 1, 60], omega_radius="1e-5")
    assert enclosure.outcome is Outcome.TOO_WIDE
    assert enclosure.times == (1,)
    assert 1 < enclosure.until < 60


def test_a_narrow_box_costs_no_more_digits_than_it_leaves():
    scene = SCENES["lagrange/nutation"]
    wide = polhode.certify(scene, [2], digits=200, omega_radius="1e-6")
    assert wide.noise < 120
    none = polhode.certify(scene, [2], digits=30, omega_radius=0)
    assert none.digits[0] >= 30


# -- how it is said ---------------------------------------------------------------------------


def test_intervals_in_a_file_are_the_radii(tmp_path, capsys):
    path = tmp_path / "box.toml"
    path.write_text(FILE, encoding="utf-8")
    enclosure = polhode.certify(path, [1])
    radii = Fraction(2, 10**9), Fraction(1, 10**8), 0
    assert enclosure.omega_radius == radii
    same = polhode.certify(DATA, [1], omega_radius=radii)
    assert enclosure.centres == same.centres
    assert enclosure.radii == same.radii
    assert "(1/500000000, 1/100000000, 0) at most" in enclosure.statement[1]
    assert main(["certify", str(path), "--json", "--at", "1"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["omega_radius"] == ["0.000000002", "0.00000001", "0"]
    assert "every motion through a state" in document["statement"][1]


@pytest.mark.parametrize("written", ["1/3 \u00b1 -1e-8", "1/3 \u00b1", "1/3 \u00b1 1 \u00b1 2"])
def test_intervals_that_are_none_are_refused(tmp_path, written):
    path = tmp_path / "box.toml"
    path.write_text(TILTED.replace('"1/3"', f'"{written}"'), encoding="utf-8")
    with pytest.raises(BadInput, match=r"a middle and a radius|a number") as fault:
        polhode.certify(path, [1])
    assert fault.value.key == "start.omega"


@pytest.mark.parametrize("written", ["20 \u00b1 1e-6 deg/s", "20 deg/s \u00b1 1e-6"])
def test_a_unit_at_the_middle_or_the_radius_alone_is_refused(tmp_path, written):
    """The box was one around 20 rad/s."""
    path = tmp_path / "box.toml"
    path.write_text(TILTED.replace('"1/3"', f'"{written}"'), encoding="utf-8")
    with pytest.raises(BadInput, match="expected a unit at the middle and at the radius, or none"):
        polhode.certify(path, [1])
    path.write_text(TILTED.replace('"1/3"', '"0 \u00b1 1e-6 deg/s"'), encoding="utf-8")
    assert polhode.certify(path, [1]).omega_radius[1] == Fraction(1746, 10**11)


@pytest.mark.parametrize("mark", ["\u00b1", "+-", "+\u2212", "+/-"])
@pytest.mark.parametrize("verb", ["run", "check", "levels", "frequencies", "reference"])
def test_what_takes_one_motion_refuses_intervals(tmp_path, refusal, verb, mark):
    text = TILTED.replace('"1/3"', f'"1/3 {mark} 1e-8"')
    (tmp_path / "box.toml").write_text(text, encoding="utf-8")
    line = refusal(verb, "box.toml")
    assert "start.omega" in line
    assert "polhode certify" in line


@pytest.mark.parametrize(
    ("radius", "line"),
    [
        *((x, "omega_radius") for x in (-1, (1, 2), ("1e-9", "1e-9", "x"), [1e-9] * 4)),
        # too wide for any time, and huge
        ("1/10", "narrower intervals, to be followed to t = 3"),
        ("1e300", "narrower intervals, to be followed to t = 3"),
    ],
)
def test_radii_that_are_none_or_too_wide_are_refused(radius, line):
    with pytest.raises(BadInput, match=line):
        polhode.certify(SCENES["tilted"], [3], omega_radius=radius)


def test_a_radius_in_other_units_is_rounded_up(tmp_path):
    path = tmp_path / "box.toml"
    path.write_text(TILTED.replace('"1/3"', '"20 deg/s +/- 1e-6 deg/s"'), encoding="utf-8")
    enclosure = polhode.certify(path, [1])
    assert enclosure.omega_radius == (0, Fraction(1746, 10**11), 0)
    assert abs(float(enclosure.scene.omega[1]) - math.radians(20)) < 1e-15


def test_what_a_box_cannot_have_is_refused(tmp_path):
    path = tmp_path / "box.toml"
    path.write_text(FILE, encoding="utf-8")
    with pytest.raises(BadInput, match="no value together with intervals"):
        polhode.certify(path, [1], omega_radius="1e-9")
    with pytest.raises(BadInput, match="numbers, for a certificate"):
        polhode.certify(path, [1]).save(tmp_path / "box.json")
    assert main(["certify", str(path), "-o", str(tmp_path / "box.json")]) == 2
    assert not (tmp_path / "box.json").exists()
    pole = replace(polhode.load("lagrange/from-the-pole"), outputs=("angles",))
    with pytest.raises(BadInput, match="depends on omega"):
        polhode.certify(pole, [1], omega_radius="1e-9")


def test_a_box_around_rest_has_no_size_to_compare_with():
    still = polhode.top(moments=[1, 2, 3], omega=[0, 0, 0], weight=0)
    enclosure = polhode.certify(still, [1], omega_radius="1e-9")
    assert enclosure.digits == (0.0,)
