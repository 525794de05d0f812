"""The heavy top benchmark: what is committed is what is proved, and made again to the bit."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from fractions import Fraction

import pytest

import benchmark
import make
import polhode
from benchmark import COLUMNS, DIGITS, TOPS, certified_values
from polhode.certificates import verify
from polhode.numbers.conversion import exactly
from polhode.numbers.flint_context import ctx
from shared.tools import tiers
from test_house import TOP

FOLDER = TOP / "reports" / "benchmark"
NAMED = {top.name: top for top in TOPS}


def rows(name):
    with open(FOLDER / f"{name}.csv", newline="") as file:
        header, *values = csv.reader(file)
    assert tuple(header) == COLUMNS
    return values


def test_the_folder_is_the_one_that_is_made():
    assert len(NAMED) == 24
    names = {path.name for path in FOLDER.iterdir()}
    own = {f"{name}{end}" for name in NAMED for end in (".csv", ".certificate.json")}
    assert names == own | {*benchmark.CHECKERS, benchmark.DATA, benchmark.PAGE}
    assert (FOLDER / benchmark.PAGE).read_text() == benchmark.page()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["n-kowalewski-motion"])
def test_values_are_made_again_to_the_bit(name):
    assert (FOLDER / f"{name}.csv").read_text() == certified_values(NAMED[name]).csv


def certificates_are_made_again_to_the_bit_and_proved(name, tmp_path):
    assert make.main(["benchmark", "--only", name, "-o", str(tmp_path)]) == 0
    written = sorted(tmp_path.iterdir())
    assert [path.name for path in written] == [f"{name}.certificate.json", f"{name}.csv"]
    for path in written:
        assert path.read_bytes() == (FOLDER / path.name).read_bytes()
    assert polhode.verify(written[0])


@pytest.mark.parametrize("name", NAMED)
def test_each_certificate_states_the_values_of_the_scene(name):
    """Its exact numbers, or balls that hold them, and the start that the values begin with."""
    stored = json.loads((FOLDER / f"{name}.certificate.json").read_text())
    first, *values = rows(name)
    assert len(values) == len(stored["statement"]) == 10
    for row, statement in zip(values, stored["statement"], strict=True):
        assert Fraction(row[0]) == Fraction(statement["t"])
        middles, radii = zip(*statement["balls"], *statement["attitude"], strict=True)
        assert [*middles] == row[1:]
        for x, radius in zip(row[1:], radii, strict=True):
            unit = Fraction(1, 10 ** len(x.partition(".")[2]))
            assert Fraction(radius) == unit * Fraction(51, 100)
        largest = max(abs(Fraction(x)) for x in row[1:4])
        assert Fraction(radii[0]) < largest / 10**DIGITS or largest < 1
    scene, data = polhode.load(NAMED[name].case), stored["scene"]
    moments = [scene.body.inertia[k][k] for k in range(3)]
    numbers = [*moments, *scene.body.centre, scene.body.weight, *scene.omega, *scene.gamma]
    stored_numbers = [*data["moments"], *data["centre"], data["weight"], *data["omega"]]
    for x, y in zip([*stored_numbers, *data["gamma"]], numbers, strict=True):
        if isinstance(x, str):
            assert Fraction(x) == y
        else:
            middle, radius = map(Fraction, x)
            assert abs(middle - exactly_of(y)) <= 2 * radius
    for x, y in zip(data["attitude"], first[7:], strict=True):
        middle = Fraction(x[0] if isinstance(x, list) else x)
        assert abs(middle - Fraction(y)) <= Fraction(1, 2 * 10**DIGITS)


def exactly_of(x):
    from polhode.numbers.exact import binary, rounded

    return binary(*rounded(x, 2000))


@pytest.mark.parametrize(
    "name",
    tiers(["lagrange-looping"], ["euler-largest-axis", "grioli-precession"]),
)
def test_values_are_those_of_the_closed_form(name):
    """Which shares no code with the enclosure: every place, rounded."""
    scene = replace(polhode.load(NAMED[name].case), outputs=("attitude",))
    form = polhode.reference(scene)
    assert form.is_closed_form
    _, *values = rows(name)
    times = [Fraction(t) for t in NAMED[name].times]
    with_turn = form.attitude(times, DIGITS + 8)
    states = form.at(times, DIGITS + 8)
    for row, state, turn in zip(values, states, with_turn, strict=True):
        for x, y in zip(row[1:], [*state, *turn], strict=True):
            places = len(x.partition(".")[2])
            assert abs(Fraction(x) - exactly(y)) < Fraction(51, 100 * 10**places)


def test_a_value_that_is_changed_in_its_last_place_is_not_proved():
    name = "staude-unstable"
    stored = json.loads((FOLDER / f"{name}.certificate.json").read_text())
    last = stored["statement"][0]["balls"][0]
    last[0] = last[0][:-1] + str((int(last[0][-1]) + 5) % 10)
    stored["statement"] = stored["statement"][:1]
    with (  # which the checker's own functions change as they like
        ctx.workprec(verify.COARSE),
        pytest.raises(verify.NotProved, match="p at t = 1 is not shown"),
    ):
        verify.state(stored)


def test_the_data_are_those_of_the_cases():
    stored = json.loads((FOLDER / benchmark.DATA).read_text())
    assert [top["name"] for top in stored["tops"]] == [*NAMED]
    for top in stored["tops"]:
        scene = polhode.load(top["case"])
        for key, exact in (("omega", scene.omega), ("gamma", scene.gamma)):
            for x, y in zip(top["decimal"][key], exact, strict=True):
                assert abs(Fraction(x) - exactly_of(y)) <= abs(exactly_of(y)) / 10**59
        assert Fraction(top["decimal"]["weight"]) >= 0
        assert top["attitude"] == rows(top["name"])[0][7:]
        assert top["times"] == [row[0] for row in rows(top["name"])[1:]]


def test_compare_reads_the_values_and_finds_them_right():
    judgement = polhode.compare(FOLDER / "lagrange-nutation.csv", "lagrange/nutation")
    assert judgement.worst > DIGITS - 0.2
