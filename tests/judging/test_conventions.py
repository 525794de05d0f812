"""Right tables in other conventions: each is named, applied, can be told; wrong ones have none."""

import itertools
import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput, Body
from polhode.cli import main
from polhode.judging.tables import explanations
from shared import drifting_files as files
from shared.steady_precession import silent_scene
from shared.tables import ANGLES, ATTITUDE, STATE, of_run, right, text, through
from shared.tools import of_table, tiers

CASE = "lagrange/nutation"
TIMES = [Fraction(k, 8) for k in range(33)]
OMEGA, GAMMA = STATE[:3], STATE[3:]
WHOLE = (*STATE, *ATTITUDE)


# -- right tables in another convention -------------------------------------------------------


def motion_of(table):
    """The columns as rows of vectors."""
    vectors = [np.array([table[n] for n in names]).T for names in (OMEGA, GAMMA, ATTITUDE)]
    return files.Motion(table["t"], *vectors)


def by(change):
    """A change of a motion as one of its columns; angles stay."""
    return lambda table: table | files.columns(change(motion_of(table)))


def renamed(**others):
    """Columns that hold what stands in others."""
    return lambda table: table | {name: table[source] for name, source in others.items()}


def scaled(names, factor):
    return lambda table: table | {n: factor * np.asarray(table[n]) for n in names}


def after(*changes):
    def changed(table):
        for change in changes:
            table = change(table)
        return table

    return changed


def moved(steps):
    """Each row at the time of another, so many rows on."""

    def changed(table):
        t = table["t"][:-1] if steps > 0 else table["t"][1:]
        rows = slice(1, None) if steps > 0 else slice(None, -1)
        return {"t": t} | {n: x[rows] for n, x in table.items() if n != "t"}

    return changed


def numbered(names):
    """A quaternion whose components are called q1 to q4."""

    def changed(table):
        others = {n: x for n, x in table.items() if n not in ATTITUDE}
        return others | {f"q{k + 1}": table[n] for k, n in enumerate(names)}

    return changed


def either_sign(table):
    signs = 1 - 2 * (np.arange(len(table["t"])) % 3 == 1)
    return table | {n: signs * table[n] for n in ATTITUDE}


def yaw_pitch_roll(table):
    """R = Rz(yaw) Ry(pitch) Rx(roll), written out from its matrix."""
    r = files.matrix(np.array([table[n] for n in ATTITUDE]).T)
    yaw, roll = np.arctan2(r[:, 1, 0], r[:, 0, 0]), np.arctan2(r[:, 2, 1], r[:, 2, 2])
    return table | dict(zip(ANGLES, (yaw, np.arcsin(-r[:, 2, 0]), roll), strict=True))


def shifted(name, by):
    return lambda table: table | {name: table[name] + by}


DEGREES, LAST = scaled(OMEGA, 180 / np.pi), by(files.scalar_last)
ANGLES_IN_DEGREES = scaled(ANGLES, 180 / np.pi)

#: Name: columns of the table, its change, and as what it is read.
READ = {
    "scalar last": (ATTITUDE, LAST, "attitude scalar-last"),
    "q1 the scalar": (ATTITUDE, numbered(ATTITUDE), "attitude q1 the scalar"),
    "inverse": (ATTITUDE, by(files.inverse), "attitude body from space"),
    "inverse, scalar last": (
        ATTITUDE,
        after(by(files.inverse), LAST),
        "attitude scalar-last, body from space",
    ),
    "y up": (ATTITUDE, by(files.Y_UP), "attitude y up, space x y z = x z -y"),
    "z down": (WHOLE, by(files.in_space(0, 1, 0, 0)), "attitude z down, space x y z = x -y -z"),
    "body axes": (
        WHOLE,
        by(files.other_body_axes),
        "omega p q r = p -q -r; gamma gamma1 gamma2 gamma3 = gamma1 -gamma2 -gamma3; "
        "attitude body x y z = x -y -z",
    ),
    "downward": (STATE, by(files.downward), "gamma the downward vertical"),
    "degrees": (OMEGA, DEGREES, "omega degrees"),
    "rpm": (STATE, scaled(OMEGA, 30 / np.pi), "omega rpm"),
    "exchanged": (WHOLE, by(files.exchanged), "omega p q r = q p r"),
    "exchanged, in degrees": (
        STATE,
        after(DEGREES, by(files.exchanged)),
        "omega p q r = q p r degrees",
    ),
    "cyclic": (
        STATE,
        renamed(p="r", q="p", r="q", gamma1="gamma3", gamma2="gamma1", gamma3="gamma2"),
        "omega p q r = q r p; gamma gamma1 gamma2 gamma3 = gamma2 gamma3 gamma1",
    ),
    "z reflected": (
        STATE,
        scaled(("r", "gamma3"), -1),
        "omega p q r = p q -r; gamma gamma1 gamma2 gamma3 = gamma1 gamma2 -gamma3",
    ),
    "degrees, scalar last": (WHOLE, after(DEGREES, LAST), "omega degrees; attitude scalar-last"),
    "angles in degrees": (ANGLES, ANGLES_IN_DEGREES, "angles in degrees"),
    "angles of another turn": (
        ANGLES,
        after(shifted("psi", 2 * np.pi), ANGLES_IN_DEGREES),
        "angles in degrees",
    ),
    "early": (OMEGA, moved(1), "t one step early"),
    "state early": (STATE, moved(1), "t one step early"),
    "attitude early": (ATTITUDE, moved(1), "t one step early"),
    "late, from the start": (GAMMA, moved(-1), "t from its first row on (0.125)"),
    "another beginning": (STATE, shifted("t", 100), "t from its first row on (100)"),
    "counted down": (
        STATE,
        after(scaled(["t"], -1), shifted("t", 3)),
        "t of the other sense, from its last row on (3)",
    ),
    "milliseconds": (STATE, scaled(["t"], 1000), "t milliseconds"),
    "nanoseconds": (STATE, scaled(["t"], 1e9), "t nanoseconds"),
    "minutes": (STATE, scaled(["t"], 1 / 60), "t minutes"),
    "hours": (STATE, scaled(["t"], 1 / 3600), "t hours"),
    "days": (STATE, scaled(["t"], 1 / 86400), "t days"),
    "milliseconds of a clock": (
        STATE,
        after(shifted("t", 5000), scaled(["t"], 1000)),
        "t milliseconds, from its first row on (5e+06)",
    ),
    "milliseconds, scalar last": (
        WHOLE,
        after(LAST, scaled(["t"], 1000)),
        "t milliseconds; attitude scalar-last",
    ),
}
#: The same of conventions that are told and not applied.
REPORTED = {
    "along space": (OMEGA, by(files.along_space), "omega along the axes of space"),
    "along space, in degrees": (
        OMEGA,
        after(by(files.along_space), DEGREES),
        "omega along the axes of space degrees",
    ),
    "yaw, pitch, roll": (ANGLES, yaw_pitch_roll, "angles turns about z-y-x"),
    "yaw, pitch, roll in degrees": (
        ANGLES,
        after(yaw_pitch_roll, ANGLES_IN_DEGREES),
        "angles turns about z-y-x in degrees",
    ),
}


def whole(case=CASE):
    return right(case, TIMES, "at", "attitude", "angles")


def some(table, names):
    return {n: x for n, x in table.items() if n in ("t", "q4", *names)}


def test_a_right_table_is_read_as_it_stands():
    judgement = polhode.compare(whole(), CASE)
    assert (judgement.reading, judgement.readings, judgement.causes) == (None, (), ())
    assert judgement.worst > 14.5
    run = polhode.integrate(replace(polhode.load(CASE), outputs=()), at=TIMES)
    assert polhode.compare(run).readings == ()
    last = numbered([*ATTITUDE[1:], "q0"])(whole())
    assert polhode.compare(some(last, ATTITUDE), CASE).reading is None


QUICK = ("scalar last", "z down", "exchanged", "angles in degrees", "minutes")


@pytest.mark.parametrize("name", of_table(READ, *QUICK))
def test_a_convention_is_named_and_applied_and_can_be_told(name):
    names, change, words = READ[name]
    table = some(change(whole()), names)
    judgement = polhode.compare(table, CASE)
    assert judgement.reading == words
    assert judgement.worst > 14
    assert judgement.limit in ("rounding", "")
    assert f"read as {words}" in str(judgement)
    assert all(
        reading.as_it_stands < 1.1 and 14 < reading.digits <= 16 for reading in judgement.readings
    )
    assert polhode.compare(table, CASE, read=words).part_digits == judgement.part_digits


@pytest.mark.parametrize("name", ["scalar last", "exchanged"])
def test_a_table_is_judged_as_it_stands_where_that_is_asked(name):
    names, change, _ = READ[name]
    plain = polhode.compare(some(change(whole()), names), CASE, as_it_stands=True)
    assert (plain.reading, plain.readings) == (None, ())
    assert plain.worst < 1.1


@pytest.mark.parametrize("name", REPORTED)
def test_a_convention_that_is_not_applied_is_named(name):
    names, change, words = REPORTED[name]
    table = some(change(whole()), names)
    judgement = polhode.compare(table, CASE)
    (reading,) = judgement.readings
    assert f"{reading.part} {reading.convention}" == words
    assert reading.digits > 13
    assert (judgement.worst, judgement.reading) == (0, None)
    assert f"read as {reading.convention}" in str(judgement)
    with pytest.raises(BadInput, match="reported, and not applied"):
        polhode.compare(table, CASE, read=words)


def test_a_quaternion_and_its_opposite_are_one_attitude():
    table = some(either_sign(whole()), ATTITUDE)
    judgement = polhode.compare(table, CASE)
    assert (judgement.reading, judgement.readings) == (None, ())
    assert judgement.worst > 14.5
    table["q2"][7] += 1e-6
    assert polhode.compare(table, CASE).worst == pytest.approx(6, abs=0.01)
    last = polhode.compare(some(LAST(either_sign(whole())), ATTITUDE), CASE)
    assert (last.reading, last.worst > 14.5) == ("attitude scalar-last", True)


def test_angles_beyond_a_pole_are_those_of_the_same_rotation():
    table = some(whole(), ANGLES)
    for k in range(0, len(table["t"]), 2):  # as an integrator of angles goes on behind a pole
        table["psi"][k] += np.pi
        table["theta"][k] = 2 * np.pi - table["theta"][k]
        table["phi"][k] -= np.pi
    judgement = polhode.compare(table, CASE)
    assert (judgement.reading, judgement.readings) == (None, ())
    assert judgement.worst > 14
    table["theta"][4] += 1e-6
    assert polhode.compare(table, CASE).worst == pytest.approx(6, abs=0.01)
    table["theta"] = [-theta for theta in whole()["theta"]]  # of one name and the other
    assert polhode.compare(table, CASE).worst == 0


def test_a_body_that_turns_over_past_both_poles_has_right_angles():
    """Its theta goes on by whole turns, of which half are of the other names."""
    table = some(whole(), ANGLES)
    for k in range(0, len(table["t"]), 2):
        table["theta"][k] -= 2 * np.pi
    judgement = polhode.compare(table, CASE)
    assert (judgement.reading, judgement.readings) == (None, ())
    assert judgement.worst > 14
    table["theta"][4] += 1e-6
    assert polhode.compare(table, CASE).worst == pytest.approx(6, abs=0.01)
    poles = {"t": [0, 1], "theta": [0.0, 2 * np.pi]}
    assert polhode.compare(poles, "lagrange/sleeping-stable").worst > 15


def test_a_theta_beyond_pi_by_less_than_doubles_tell_is_one_of_the_same_rotation():
    body = {"moments": [1, 1, 0.5], "centre": [0, 0, 1], "weight": 1, "omega": [0, 0, 1]}
    scene = polhode.top(**body, angles=[0, "pi - 1/10**20", 0], end=1)
    pi, beyond = "3.14159265358979323846264338327950288", "3.14159265358979323847264338327950288"
    table = {"t": ["0"], "psi": [pi], "theta": [beyond], "phi": ["-" + pi]}
    assert polhode.compare(table, scene).worst > 30
    table["phi"] = ["0"]
    assert polhode.compare(table, scene).worst == 0


def test_omega_along_space_is_named_where_the_attitude_is_enclosed():
    """A table of the state alone, of a closed form that has the state alone."""
    case, times = "goryachev-chaplygin/rotating", [Fraction(k, 8) for k in range(12)]
    assert polhode.reference(case).encloses_attitude
    table = by(files.along_space)(with_attitude(case, times))
    (judgement,) = polhode.compare({n: table[n] for n in ("t", *STATE)}, case).readings
    assert (judgement.part, judgement.convention) == ("omega", "along the axes of space")


#: Of these, alone in other motions and two at once, the columns are of all parts.
MIXED = ("y up", "z down", "body axes", "degrees", "exchanged", "scalar last", "inverse", "early")
MIXED += ("downward",)


def mixed(case, *names):
    table = some(whole(case), WHOLE)
    for name in names:
        table = READ[name][1](table)
    return polhode.compare(table, case)


@pytest.mark.parametrize(
    ("case", "name"),
    tiers(
        [("lagrange/looping", "y up"), ("euler/turned-axes", "scalar last")],
        [
            ("euler/turned-axes", "y up"),
            ("lagrange/looping", "body axes"),
            ("lagrange/looping", "exchanged"),
            ("euler/turned-axes", "early"),
        ],
    ),
)
def test_a_convention_is_named_in_other_motions(case, name):
    judgement = mixed(case, name)
    assert READ[name][2].partition(";")[0] in judgement.reading
    assert judgement.worst > 13


@pytest.mark.slow
def test_two_conventions_at_once_are_read():
    """Nine of ten pairs at least; what is read is read with all its digits."""
    pairs = [*itertools.combinations(MIXED, 2)][::3]
    named = 0
    for pair in pairs:
        judgement = mixed(CASE, *pair)
        assert all(reading.digits > 9 for reading in judgement.readings), pair
        named += bool(judgement.readings)
    assert named >= 0.9 * len(pairs)


@pytest.mark.slow
def test_what_limits_the_digits_of_a_table_that_was_read_is_told():
    """What is left is the error of the table as it is read."""
    judgement = polhode.compare(shifted("p", 1e-5)(DEGREES(some(whole(), STATE))), CASE)
    assert judgement.reading == "omega degrees"
    assert judgement.limit.startswith("method")
    assert "fewer than double precision allows" in str(judgement)


def test_a_motion_without_a_closed_form_is_read_by_a_short_proof():
    """Of times in milliseconds, and of a clock's, beside another convention."""
    case = "general/asymmetric-chaotic"
    table = of_run(polhode.integrate(case, at=[Fraction(k, 4) for k in range(13)]))
    exchanged = renamed(p="q", q="p")(table)
    for change, words in (
        (scaled(["t"], 1000), "t milliseconds"),
        (shifted("t", 1234.5), "t from"),
    ):
        forecasts = []
        judgement = polhode.compare(change(exchanged), case, forecast=forecasts.append)
        assert words in judgement.reading
        assert "p q r = q p r" in judgement.reading
        assert judgement.worst > 11
        assert max(forecasts, default=0) < 5


def other_body(inertia, weight):
    """A change of a scene's body by signs of its products of inertia and of its weight."""

    def changed(scene):
        body = scene.body
        rows = [
            tuple(x * sign for x, sign in zip(row, signs, strict=True))
            for row, signs in zip(body.inertia, inertia, strict=True)
        ]
        return replace(scene, body=Body(tuple(rows), body.centre, body.weight * weight))

    return changed


def full(**others):
    numbers = {"omega": ["0.5", "1.2", "-0.7"], "quaternion": ["0.8", "0.2", "-0.4", "0.4"]}
    inertia = [["1.3", "0.1", "-0.2"], ["0.1", "1.1", "0.15"], ["-0.2", "0.15", "0.9"]]
    body = {"inertia": inertia, "centre": ["0.1", "0.2", "0.3"], "weight": "1.5"}
    return polhode.top(**(body | numbers | others), outputs=["attitude"])


SAME = ((1, 1, 1), (1, 1, 1), (1, 1, 1))
ALL = ((1, -1, -1), (-1, 1, -1), (-1, -1, 1))
XZ = ((1, 1, -1), (1, 1, 1), (-1, 1, 1))
YZ = ((1, 1, 1), (1, 1, -1), (1, -1, 1))
LIGHT = {"weight": "0.02", "omega": [1, "0.3", 2]}

#: Scenes of which a table is the motion, changed so; and the words.
OTHER_SCENES = {
    "lagrange": ("lagrange/nutation", other_body(SAME, -1), "a weight"),
    "chaotic": ("general/asymmetric-chaotic", other_body(SAME, -1), "a weight"),
    "light": (full(**LIGHT), other_body(SAME, -1), "a weight"),
    "products": (full(), other_body(ALL, 1), "products of inertia"),
    "free": (full(weight=0), other_body(ALL, 1), "products of inertia"),
    "Ixz": (full(), other_body(XZ, 1), "products of inertia of the other sign (Ixz)"),
    "Iyz": (full(**LIGHT), other_body(YZ, 1), "products of inertia of the other sign (Iyz)"),
    "quaternion": (
        full(quaternion=["0.2", "-0.4", "0.4", "0.8"]),
        lambda _: full(),
        "the scene's quaternion taken as scalar-last",
    ),
}


@pytest.mark.parametrize("which", of_table(OTHER_SCENES, "lagrange", "free"))
def test_the_digits_under_a_reading_are_those_under_it(which):
    """They were those of the file as it stands, under the right words."""
    own, change, words = OTHER_SCENES[which]
    own = replace(polhode.load(own), outputs=("attitude",), events=())
    run = polhode.integrate(change(own), at=[Fraction(k, 4) for k in range(13)])
    table = of_run(run) | dict(zip(ATTITUDE, np.array(run.attitude).T, strict=True))
    judgement = polhode.compare(some(table, OMEGA if which == "chaotic" else WHOLE), own)
    assert (judgement.worst < 3, judgement.reading) == (True, None)
    assert judgement.readings
    facts = {x.name: x.values for x in judgement.fact("readings").columns}
    for reading, digits in zip(judgement.readings, facts["digits"], strict=True):
        assert words in reading.convention
        assert reading.as_it_stands < 3 < 13.5 < reading.digits == digits
        assert f"; right with {reading.convention}: {reading.digits:.1f} digits" in str(judgement)
        assert reading.as_it_stands == pytest.approx(
            min(judgement.part_digits[reading.part]), abs=1
        )


# -- conventions that somebody tells ----------------------------------------------------------


def test_what_is_told_is_applied_whatever_it_gives_and_nothing_else_is():
    table = some(whole(), WHOLE)
    wrong = polhode.compare(table, CASE, read="omega degrees")
    assert (wrong.reading, wrong.worst < 1) == ("omega degrees", True)
    judgement = polhode.compare(LAST(DEGREES(table)), CASE, read=" omega  degrees;")
    assert (judgement.worst_part, judgement.worst < 1) == ("attitude", True)
    assert [reading.part for reading in judgement.readings] == ["omega"]
    later = after(shifted("t", 5), scaled(["t"], 1000), DEGREES)(table)
    words = "t milliseconds; t from its first row on (5); omega degrees"
    assert polhode.compare(later, CASE, read=words).worst > 14


@pytest.mark.parametrize(
    ("words", "refused"),
    [
        ("sideways", "sideways: expected readings that this table can have: attitude scalar-last"),
        ("attitude scalar-last; sideways", "sideways: expected readings"),
        (" ; ", "read = ;: expected readings"),
        ("scalar-last", "(did you mean 'attitude scalar-last'?)"),
        ("omega degrees", "omega degrees: expected readings"),
        ("attitude q1 the scalar", "expected readings"),
        ("t of another clock: rows belong to t - 12.5", "t - 12.5: expected readings"),
        ("attitude scalar-last; attitude scalar-last", "no second reading of attitude"),
    ],
)
def test_the_refusal_names_the_word_and_why(words, refused):
    with pytest.raises(BadInput) as fault:
        polhode.compare(some(LAST(whole()), ATTITUDE), CASE, read=words)
    assert "read = " in str(fault.value)
    assert refused in str(fault.value)


def test_the_command_reads_as_it_is_told(tmp_path, capsys):
    path = tmp_path / "x.csv"
    path.write_text(text(DEGREES(some(whole(), STATE))))
    command = ["compare", str(path), CASE]
    assert main([*command, "--read", "omega degrees"]) == main(command) == 0
    assert capsys.readouterr().out.count("read as omega degrees") == 2
    assert main([*command, "--read", "sideways"]) == 2
    assert main([*command, "--at-least", "6"]) == 3
    assert main([*command, "--at-least", "6", "--read", "omega degrees"]) == 0


def test_what_is_told_of_times_beside_no_whole_vector_has_no_digits_of_its_own():
    """It was told 0.0 digits."""
    judgement = polhode.compare(
        some(scaled(["t"], 1000)(whole()), "p"), CASE, read="t milliseconds"
    )
    assert judgement.worst > 14
    assert [*map(str, judgement.readings)] == ["t read as milliseconds"]


@pytest.mark.slow
@pytest.mark.parametrize("gap", [0, 5])
def test_a_table_with_an_empty_cell_is_read_by_its_whole_rows(gap):
    """Where one of the rows that tell had it, no convention was found, and no number."""
    table = DEGREES(some(whole(), STATE))
    table["q"][gap] = np.nan
    judgement = polhode.compare(table, CASE)
    assert (judgement.reading, judgement.worst > 14) == ("omega degrees", True)
    sentence = (
        "drift of the integrals was not judged: it takes all cells of the state, and some are"
    )
    assert sentence in str(judgement)
    assert "it takes all of p, q, r, gamma1, gamma2, gamma3, and the table has no gamma1" in str(
        polhode.compare(some(table, OMEGA), CASE)
    )
    spun = polhode.top(moments=[1, 1, "0.51"], centre=[0, 0, 1], weight=1, **START)
    rows = of_run(polhode.integrate(spun, at=TIMES))
    rows["q"][gap] = np.nan
    (cause,) = polhode.compare(rows, CASE).causes[:1]
    assert cause.words.startswith("the moment C = 0.51 ")


#: Of the case.
START = {"omega": ["0.16", "0.3", "4.1"], "gamma": ["0.8", 0, "0.6"]}


def test_times_in_minutes_are_shown_in_full():
    """Sixty times a double: 3.8749999999999996 was shown, and is 3.875."""
    rows = {n: x[[0, 1, 8, 31]] for n, x in some(whole(), STATE).items()}
    judgement = polhode.compare(scaled(["t"], 1 / 60)(rows), CASE)
    lines = judgement.details().splitlines()[2:6]
    assert [line.split()[0] for line in lines] == ["0", "0.125", "1", "3.875"]


@pytest.mark.parametrize(("factor", "most"), [(1000, 3), (1e6, 2), (1 / 60, 12)])
def test_a_unit_is_tried_before_the_times_that_lie_farther_away(monkeypatch, factor, most):
    """All others were followed as far as 100 000 radians, which took a third of a second."""
    followed_times = []
    followed = explanations.integrated
    monkeypatch.setattr(
        explanations,
        "integrated",
        lambda *arguments: followed_times.append(1) or followed(*arguments),
    )
    assert polhode.compare(scaled(["t"], factor)(some(whole(), STATE)), CASE).worst > 14
    assert 1 <= len(followed_times) <= most


# -- wrong tables -----------------------------------------------------------------------------


def early_in_part(table):
    """A step that does not explain all parts."""
    table = moved(1)(some(table, STATE))
    return table | {n: np.sin(7 * np.arange(table["t"].size)) for n in GAMMA}


def one_row(table):
    """A wrong sign in one row alone is no other axis."""
    return {n: (-x if n == "p" else x)[5:6] for n, x in some(table, STATE).items()}


def noise(table):
    draw = np.random.default_rng(20)
    return {n: x if n == "t" else draw.normal(size=x.size) for n, x in table.items()}


def departing(table):
    draw = np.random.default_rng(21)
    steps = {n: 0.03 * draw.normal(size=x.size).cumsum() for n, x in table.items()}
    return {n: x if n == "t" else x + steps[n] for n, x in table.items()}


@pytest.mark.parametrize("wrong", tiers([early_in_part], [one_row, noise, departing]))
def test_a_wrong_table_has_no_convention_by_chance(wrong):
    judgement = polhode.compare(wrong(some(whole(), STATE)), CASE)
    assert judgement.readings == ()
    assert judgement.worst < 1.5


def with_attitude(scene, times):
    """The state and the attitude of a run in double, by name, with its times."""
    scene = replace(polhode.load(scene), outputs=("attitude",), events=()).at(times)
    run = polhode.integrate(scene)
    return of_run(run) | dict(zip(ATTITUDE, np.array(run.attitude).T, strict=True))


def test_an_attitude_that_alone_is_wrong_is_read_without_a_closed_form():
    case = "general/asymmetric-regular"
    table = with_attitude(case, [Fraction(k, 2) for k in range(8)])
    table |= dict(zip(ATTITUDE, [table[n] for n in (*ATTITUDE[1:], ATTITUDE[0])], strict=True))
    judgement = polhode.compare(table, case)
    assert judgement.reading == "attitude scalar-last"
    assert judgement.worst > 13


@pytest.mark.slow
def test_a_closed_form_that_refuses_leaves_the_reading_to_the_enclosure():
    scene = silent_scene()
    table = with_attitude(scene, [Fraction(k, 2) for k in range(8)])
    for name in STATE[:3]:
        table[name] = np.degrees(table[name])
    judgement = polhode.compare(table, scene)
    assert (judgement.reading, judgement.reference.kind) == ("omega degrees", "certified")
    assert judgement.worst > 13


# -- Times of a clock, in other units, or rounded: what a judgement says of a right program


SCENE = "lagrange/nutation"
CLOCK = 10**6


def table(times, scene=SCENE, later=0, shown=float):
    """The right rows of times, with those of a clock that is so much later."""
    columns = of_run(polhode.integrate(scene, at=times))
    return columns | {"t": np.array([shown(t + Fraction(later)) for t in times])}


THIRDS = [Fraction(k, 3) for k in range(20)]  # which no clock of doubles holds


@pytest.mark.parametrize("door", ["mapping", "npz", "%.18e", "%.17g"])
def test_rounding_of_a_clocks_time_is_the_limit_whatever_the_door(tmp_path, door):
    judgement = polhode.compare(through(door, table(THIRDS, later=CLOCK), tmp_path), SCENE)
    assert judgement.subject.number.name == "double"
    assert 9 < judgement.worst < 11
    assert judgement.limit == "rounding (of the times, by up to 2e-10)"


@pytest.mark.slow
def test_more_than_the_clock_explains_is_not_blamed_on_it():
    columns = table(THIRDS, later=CLOCK)
    rows = np.column_stack([columns[n] for n in polhode.load(SCENE).columns])
    beside = polhode.compare(rows, SCENE, at=columns["t"])
    assert "as many as rounding of the times, by up to 2e-10 leaves" in str(beside)
    columns["q"] = columns["q"] + 1e-8 * np.sin(np.arange(20))
    judgement = polhode.compare(columns, SCENE)
    assert judgement.limit.startswith("method")
    assert "fewer than double precision allows: the program's steps, noise, or" in str(judgement)


@pytest.mark.slow
def test_decimals_that_are_not_evenly_spaced_are_rounded(tmp_path):
    columns = table(THIRDS, shown=lambda t: round(float(t), 6))
    path = tmp_path / "x.csv"
    path.write_text(text(columns))
    assert polhode.compare(path, SCENE).limit == "rounding (of the times, by up to 5e-07)"
    path.write_text(text(columns | {"t": np.arange(20) / 10}))
    assert not polhode.compare(path, SCENE).limit.startswith("rounding")


def test_a_unit_is_told_by_the_rows_that_a_run_reaches():
    """The last one is two million radians on, which no run in double goes."""
    times = [Fraction(k, 8) for k in range(8)] + [Fraction(2_000_000)]
    rows = np.array(polhode.reference(SCENE).at(times, 20), float)
    columns = dict(zip(polhode.load(SCENE).columns, rows.T, strict=True))
    judgement = polhode.compare(columns | {"t": [1000.0 * float(t) for t in times]}, SCENE)
    assert judgement.reading == "t milliseconds"
    assert judgement.worst > 14


@pytest.mark.slow
def test_rows_a_thousand_turns_apart_are_told_their_origin():
    """Of a body that spins fast the second row lies ten thousand radians away."""
    times = np.arange(6.0)
    columns = of_run(polhode.integrate("euler/fast-spin", at=times.tolist()))
    later = polhode.compare(columns | {"t": times + 12.5}, "euler/fast-spin")
    assert later.reading == "t from its first row on (12.5)"
    down = polhode.compare(columns | {"t": 5 - times}, "euler/fast-spin")
    assert down.reading == "t of the other sense, from its last row on (5)"
    assert 11 < min(later.worst, down.worst) < 15.96


def test_of_a_body_at_rest_no_time_is_told():
    """A rate of zero has no radian: a division by it ended in a traceback."""
    judgement = polhode.compare(table(THIRDS), "euler/rest")
    assert judgement.worst < 1


# -- A program that drifts is told its convention by its first rows; a wrong file is told none


PARTS = {"omega": STATE[:3], "gamma": STATE[3:], "attitude": ATTITUDE}
STARTS_RIGHT = 3.0  # digits of the first rows of an exact program


def scene_of(file):
    top = file.top
    return polhode.top(
        inertia=[[str(x) for x in row] for row in top.inertia],
        centre=[str(x) for x in top.centre],
        weight=str(top.weight),
        omega=[str(x) for x in top.omega],
        quaternion=[float(x) for x in file.turn],
        normalise=True,
        outputs=["attitude"],
    )


def judged(file):
    return polhode.compare(file.columns, scene_of(file))


def is_named(file, judgement):
    reading = {x.part: x.convention for x in judgement.readings}
    return all(words in reading.get(part, "") for part, words in file.words.items())


def plainly(convention):
    """A convention without the numbers of a rotation."""
    return re.sub(r"rotation of .* in", "rotation in", convention)


def right_digits(file, part):
    """Digits of a program that drifts, by one that does not, in the first rows: of vectors by
    components, of attitudes by elements of R."""
    theirs, exact = (
        np.array([columns[name][: files.EXACT_ROWS] for name in PARTS[part]]).T
        for columns in (file.columns, file.exact)
    )
    if part == "attitude":
        order = [3, 0, 1, 2] if file.words[part] == "scalar-last" else [0, 1, 2, 3]
        theirs, exact = (files.matrix(q[:, order]).reshape(-1, 9) for q in (theirs, exact))
    size = np.linalg.norm(exact, axis=1).max() if part == "omega" else 1
    with np.errstate(divide="ignore"):
        return -np.log10(np.abs(theirs - exact).max(axis=1) / size)


def is_wrong(file, reading):
    """Whether a program that does not drift is not right in a reading."""
    scene = scene_of(file)
    if any(words in reading.convention for words in file.words.values()):
        return False
    if reading.change is None:
        exact = polhode.compare(file.exact, scene).readings
        conventions = {(x.part, plainly(x.convention)) for x in exact}
        return (reading.part, plainly(reading.convention)) not in conventions
    try:
        exact = polhode.compare(file.exact, scene, read=f"{reading.part} {reading.convention}")
    except BadInput:
        return True
    return min(exact.part_digits[reading.part]) < STARTS_RIGHT


@pytest.mark.slow
@pytest.mark.parametrize("name", ["degrees", "turned in space"])
def test_a_drifting_file_is_told_its_convention(name):
    """The digits of its first row and of later ones, in the convention that is named."""
    file = files.plain_file(name)
    judgement = judged(file)
    assert judgement.worst < 3
    assert is_named(file, judgement), judgement.readings
    for part in file.words:
        (reading,) = [x for x in judgement.readings if x.part == part]
        first, *_, last = reading.rows
        assert 12 > first[1] > 2 > last[1] or first[1] > 12 > 3 > last[1]
        assert f"{last[1]:.1f} at t = 4" in str(reading)
        for t, digits in reading.rows[1:-1]:
            digits_there = right_digits(file, part)[list(file.columns["t"]).index(float(t))]
            assert digits == pytest.approx(digits_there, abs=0.4)
        exact = "turned" not in name  # where the first row tells the rotation
        assert ("exact at t = 0, " in str(reading)) == exact


@pytest.mark.slow
def test_a_rotation_that_the_first_row_tells_needs_no_more_digits_than_a_name():
    """Four rows of two digits; three digits were asked, as of a number that is fitted to all."""
    file = files.of_convention(277, "turned in space")
    (reading,) = judged(file).readings
    assert reading.convention.startswith("a constant rotation of 132° about (0.532, -0.716, 0.452)")
    assert [round(digits, 1) for _, digits in reading.rows] == [2.4, 2.1]


def test_a_rotation_of_a_motion_in_a_plane_is_told_of_the_scenes_own_angles():
    """There x-y-x of the body from space, with another rotation, is as right, and stranger."""
    case, times = "kovalevskaya/pendulum-equatorial", [Fraction(k, 8) for k in range(5)]
    motion = motion_of(with_attitude(case, times))
    r = files.matrix(files.turned_in_body(motion, np.random.default_rng(3)).turn)
    psi, phi = np.arctan2(r[:, 0, 2], -r[:, 1, 2]), np.arctan2(r[:, 2, 0], r[:, 2, 1])
    table = {"t": times, "psi": psi, "theta": np.arccos(r[:, 2, 2]), "phi": phi}
    (reading,) = polhode.compare(table, case).readings
    assert reading.convention.startswith("turns about z-x-z, a constant rotation of")


@pytest.mark.slow
def test_a_fast_top_is_told_the_unit_of_omega():
    """Its spin is hardly moved, so that what comes after the first row says little of the axes."""
    numbers = {"centre": [0, 0, 1], "weight": 20, "angles": [0, "25°", 0], "rates": [0, 0, 94]}
    top = polhode.top(moments=[4, 4, "1.5"], **numbers)
    f, h = polhode.field(top), 2e-4
    states = [np.array(f.start)]
    for _ in range(1500):
        states.append(states[-1] + h * np.array(f(0, states[-1])))
    rows = np.array(states[::50])
    for unit, word in ((180 / np.pi, "degrees"), (30 / np.pi, "rpm")):
        table = {"t": np.arange(31) / 100, **dict(zip("pqr", unit * rows[:, :3].T, strict=True))}
        (reading,) = polhode.compare(table, top).readings
        assert reading.convention == word
        assert reading.rows[0][1] > 12 > 4 > reading.rows[-1][1]
    table["r"] = table["r"] * 1.3  # a factor that is no unit
    assert polhode.compare(table, top).readings == ()


def drifting_files_are_named_right():
    """At least 95 in a hundred are named, and none wrongly."""
    count = 300
    missed, wrong = Counter(), []
    for seed in range(count):
        name = files.NAMES[seed % len(files.NAMES)]
        file = files.of_convention(seed, name)
        judgement = judged(file)
        missed[name] += not is_named(file, judgement)
        wrong += [
            (seed, name, str(reading)) for reading in judgement.readings if is_wrong(file, reading)
        ]
    assert wrong == []
    assert missed.total() <= 0.05 * count, +missed


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "name"), [(0, "another"), (20, "another weight"), (40, "noise")])
def test_wrong_files_are_told_no_convention(name, seed):
    assert judged(files.wrong_file(seed, name)).readings == ()
