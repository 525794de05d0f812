"""A number that explains a table: found where one was changed, and nowhere else."""

import json
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import Body
from polhode.cli import main
from polhode.judging.tables.hypotheses import Evidence, Hypothesis, Trial, explains
from shared.tables import STATE, euler, of_run, rk4, text
from shared.tools import of_table, tiers

TIMES = [Fraction(k, 4) for k in range(21)]


def scene(name):
    if name == "full":
        start = {"omega": ["0.5", "1.2", "-0.7"], "gamma": ["0.6", 0, "0.8"]}
        full = [["1.3", "0.1", "-0.2"], ["0.1", "1.1", "0.15"], ["-0.2", "0.15", "0.9"]]
        return polhode.top(inertia=full, centre=["0.1", "0.2", "0.3"], weight="1.5", **start)
    return replace(polhode.load(name), events=(), outputs=())


def table(scene, times=TIMES, said=TIMES):
    """The motion at these times, said to be at the plain ones."""
    return of_run(polhode.integrate(scene, at=times)) | {"t": np.array(said, dtype=float)}


def with_body(elements=(), factor=1, axis=None, weight=1):
    """Another body: elements of inertia, or the weight, times a factor; the centre moved."""

    def changed(own):
        inertia, centre = [[*row] for row in own.body.inertia], [*own.body.centre]
        for i, j in elements:
            inertia[i][j] = inertia[j][i] = own.body.inertia[i][j] * Fraction(factor)
        if axis is not None:
            centre[axis] += Fraction(1, 50)
        other_body = Body(inertia, centre, own.body.weight * Fraction(weight))
        value = [inertia[i][j] for i, j in elements[:1]] or [
            weight if axis is None else centre[axis]
        ]
        return table(replace(own, body=other_body)), float(Fraction(value[0]))

    return changed


def with_start(place):
    def changed(own):
        omega = [*own.omega]
        omega[place] += Fraction(1, 100)
        return table(replace(own, omega=tuple(omega))), float(omega[place])

    return changed


def at(value, time_of, said=TIMES):
    return lambda own: (table(own, [time_of(t) for t in said], said), value)


#: The case, how it is changed, and the words of what is found.
CHANGED = {
    "a moment": ("euler/largest-axis", with_body([(2, 2)], "1.02"), "the moment C = "),
    "two moments": ("lagrange/nutation", with_body([(0, 0), (1, 1)], "1.02"), "the moments A = B "),
    "a product": ("full", with_body([(0, 1)], "1.2"), "the element xy of inertia = "),
    "a start": ("general/asymmetric-chaotic", with_start(1), "q.* = "),
    "a weight": ("general/asymmetric-regular", with_body(weight="0.981"), ".*a weight, or a dist"),
    "a centre": ("kovalevskaya/generic", with_body(axis=1), "the centre's y = "),
    "late rows": (
        "general/asymmetric-chaotic",
        at(1 / 70, lambda t: t + Fraction(1, 70)),
        r"rows that belong to t \+ ",
    ),
    "early rows": (  # a run does not change sides
        "lagrange/nutation",
        at(-1 / 64, lambda t: t - Fraction(1, 64), TIMES[1:]),
        "rows that belong to t - ",
    ),
    "a pace": ("lagrange/nutation", at(1.001, lambda t: t * Fraction(1001, 1000)), ".*the pace"),
}


@pytest.mark.parametrize("which", of_table(CHANGED, "a moment"))
def test_what_is_another_is_found_to_its_digits(which):
    name, changed, words = CHANGED[which]
    columns, value = changed(scene(name))
    judged = polhode.compare(columns, scene(name))
    assert judged.worst < 5
    causes = [cause for cause in judged.causes if re.match(words, cause.words)]
    assert causes, judged.causes
    number = re.search(r"(?:= |t [+-] |of )([-+.\de]+)", causes[0].words)[1]
    assert abs(float(number)) == pytest.approx(abs(value), rel=1e-8)
    assert causes[0].digits > 10
    if "moment" in which:
        assert judged.causes[0] == causes[0]
        assert re.search(r"\(the scene's (is|are) [\d.]+\)$", causes[0].words)


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("a clock of 1.00001 times the pace", at(0, lambda t: t * Fraction(100_001, 100_000))),
        ("a weight, or a distance", with_body(weight=1 + Fraction(1, 10**6))),
    ],
)
def test_a_small_change_is_told_where_it_makes_a_table_right_beyond_any_method(words, change):
    """A clock ten in a million slow was called noise; quartz is no better."""
    own = scene("lagrange/nutation")
    cause = polhode.compare(change(own)[0], own).causes[0]
    assert cause.words.startswith(words)
    assert cause.digits > 12


# -- methods, which no number explains --------------------------------------------------------


def stepped(name, step, count):
    f = polhode.field(scene(name))
    y, rows = np.array(f.start), [f.start]
    for _ in TIMES[1:]:
        for _ in range(count):
            y = step(f, y, 0.25 / count)
        rows.append(y)
    columns = zip(scene(name).columns, np.array(rows).T, strict=True)
    return {"t": np.array(TIMES, dtype=float), **dict(columns)}


@pytest.mark.slow
@pytest.mark.parametrize(("step", "count"), [(euler, 200), (rk4, 4)])
def test_a_rough_method_is_explained_by_nothing(step, count):
    name = "lagrange/nutation"
    judged = polhode.compare(stepped(name, step, count), scene(name))
    assert judged.worst < 9
    assert judged.causes == ()


def noisy(own, columns, size=1e-4):
    draw = np.random.default_rng(3)
    return {n: x + size * draw.standard_normal(x.size) * (n != "t") for n, x in columns.items()}


UNEXPLAINED = {
    "exchanged axes": lambda own, columns: columns | {"p": columns["q"], "q": columns["p"]},
    "noise": noisy,
    "nonsense": lambda own, columns: noisy(own, columns, 1.0),
    "a weight by what a method may lose": lambda own, columns: noisy(
        own, with_body(weight=1 + Fraction(1, 10**6))(own)[0], 1e-8
    ),
    "two numbers": lambda own, columns: with_body([(2, 2)], "1.02")(
        replace(own, omega=(own.omega[0] + Fraction(1, 100), *own.omega[1:]))
    )[0],
}


@pytest.mark.parametrize("change", of_table(UNEXPLAINED, "exchanged axes"))
def test_it_is_explained_by_no_number(change):
    own = scene("lagrange/nutation")
    assert polhode.compare(UNEXPLAINED[change](own, table(own)), own).causes == ()


@pytest.mark.slow
def test_a_cause_is_printed_and_in_json(tmp_path, capsys):
    name = "lagrange/nutation"
    columns, _ = with_body([(2, 2)], "1.02")(scene(name))
    path = tmp_path / "x.csv"
    path.write_text(text(columns))
    assert main(["compare", str(path), name]) == 0
    said = capsys.readouterr().out
    line = "explained by the moment C = 0.51 (the scene's is 0.5), which gives 15.0 digits"
    assert line in said.splitlines()
    assert ", another number explains the error" in said
    assert "limit " not in said
    assert main(["compare", str(path), name, "--json"]) == 0
    output = json.loads(capsys.readouterr().out)["causes"]
    assert output["cause"][0] == "the moment C = 0.51 (the scene's is 0.5)"
    assert output["digits"][0] == pytest.approx(15.0, abs=0.05)


# -- equations, of which no number is another ------------------------------------------------


def of_equations(name, change):
    """Rows of a program that integrates other equations well enough."""
    f = polhode.field(scene(name))
    y, rows = np.array(f.start), [f.start]
    for _ in range(16):
        for _ in range(40):
            y = rk4(lambda t, y: change(f, y), y, 0.25 / 40)
        rows.append(y)
    rows = np.array(rows)
    return {"t": np.arange(17) / 4, **dict(zip(STATE, rows.T, strict=True))}


def constant(f, y):
    return np.concatenate([np.zeros(3), np.cross(y[3:], y[:3])])


@pytest.mark.parametrize(
    ("name", "parts"),
    tiers([("lagrange/nutation", STATE)], [("general/asymmetric-regular", STATE[:3])]),
)
def test_an_omega_that_stays_is_no_clock(name, parts):
    """It was a clock of 0 times the pace."""
    table = of_equations(name, constant)
    judgement = polhode.compare({n: table[n] for n in ("t", *parts)}, scene(name))
    (cause,) = judgement.causes
    terms = "omega x I omega and of the torque"
    assert cause.words == f"omega that stays as it is at t = 0, without the terms {terms}"
    assert cause.digits > 7
    assert "explained by omega that stays as it is at t = 0, without the terms" in str(judgement)


@pytest.mark.parametrize("pace", [Fraction(1, 8), Fraction(1, 12)])
def test_no_clock_is_slower_than_a_tenth(pace):
    own, times = scene("lagrange/nutation"), [Fraction(k, 40) for k in range(21)]
    slow = table(own, [pace * t for t in times], times)
    causes_told = [cause.words for cause in polhode.compare(slow, own).causes]
    assert any("times the pace" in words for words in causes_told) == (pace > 0.1)


def test_other_equations_are_told_where_to_look():
    name = "lagrange/nutation"
    wrong = of_equations(name, lambda f, y: f(0, y) * np.repeat([1, -1], 3))
    judgement = polhode.compare(wrong, scene(name))
    last = str(judgement).splitlines()[-1]
    words = "of a program's own equations polhode.compare_field(f, 'lagrange/nutation') names"
    assert last.startswith(words)
    right = of_equations(name, lambda f, y: f(0, y))
    assert "compare_field" not in str(polhode.compare(right, scene(name)))


# -- the one rule by which a hypothesis about a table is accepted: its edges, from both sides ------


NONE = np.zeros(4)


def comparison(digits, rival=NONE, goes=True, freedom=3, rows_fitted=0, **hypothesis):
    """Evidence of so many digits a row beside that of the table as it stands."""
    mine = np.broadcast_to(np.asarray(digits, dtype=float), (4,))
    evidence = Evidence(Hypothesis(**hypothesis), mine.copy(), rows_fitted, freedom)
    return Trial(evidence, Evidence(Hypothesis(), np.array(rival, dtype=float)), goes)


@pytest.mark.parametrize(
    ("gain", "how"),
    [
        (1.5, {}),
        (3.0, {"fitted": 1, "rows_fitted": 4}),
        (1.5, {"fitted": 3, "rows_fitted": 1}),  # for that row no longer counts
        (3.5, {"freedom": 1}),
        (9.5, {"freedom": 1, "tries": 10**6}),
        (4.75, {"freedom": 2, "tries": 10**6}),
        (9.5, {"freedom": 2, "tries": 10**6, "fitted": 1, "rows_fitted": 4}),
    ],
)
def test_so_many_digits_more_are_asked_and_no_more(gain, how):
    assert explains([comparison(gain + 0.01, **how)])
    assert not explains([comparison(gain - 0.01, **how)])


LATE = {"fitted": 1, "rows_fitted": 2}
WORSE = comparison(2, rival=np.full(4, 9.0))


def beside(mine, rival):
    """So many digits a row, where the table as it stands is right in its first half."""
    return [comparison([mine] * 4, [rival, rival, 0, 0])]


#: A rule: what it accepts, and what it does not.
RULES = {
    "a part goes with the motion": (
        [[comparison(8)]],
        [[comparison(8, goes=False)], [comparison(8), comparison(8, goes=False)]],
    ),
    "every part begins right, also one that is no better than it stands": (
        [[comparison(8), comparison(1.6)]],
        [[comparison(8), comparison(x)] for x in (1.4, 0)],
    ),
    "all parts together have more digits": ([[comparison(9.5), WORSE]], [[comparison(6.5), WORSE]]),
    "digits beyond twelve are no more certain": (
        [[comparison(20, rival=np.full(4, 10.4))]],
        [[comparison(20, rival=np.full(4, x))] for x in (10.6, 12.0)],
    ),
    # later rows that are right again do not count, nor do rows that drift after right ones
    "what is wrong in the first rows is wrong": (
        [[comparison([8, 8, 1, 0])], [comparison([4, 0, 8, 8], freedom=1)]],
        [*([comparison([x, 8, 8, 8])] for x in (0, 1.4)), [comparison([2, 0, 8, 8], freedom=1)]],
    ),
    # by more than digits of good rows differ: 0.3, or 1 where both are near the type's own
    "no row before the better one is worse": (
        [beside(5.8, 6.0), beside(9.2, 10.0)],
        [beside(5.6, 6.0), beside(8.8, 10.0)],
    ),
    "rows to which a number was fitted say nothing one by one": (
        [[comparison([0, 0, 8, 8], **LATE)]],
        [[comparison([8, 8, 0, 0], **LATE)], [comparison([8, 8, 8, 0], fitted=1, rows_fitted=4)]],
    ),
}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_accepts_and_refuses(rule):
    accepted, refused = RULES[rule]
    assert all(map(explains, accepted))
    assert not any(map(explains, refused))


@pytest.mark.parametrize(
    ("digits", "moved", "how", "goes"),
    [
        # where the motion has left its first row by a tenth, the table is nearer to it: 0.7 digits
        (1.8, [0, 0.05, 0.11, 1], {}, True),
        (1.6, [0, 0.05, 0.11, 1], {}, False),
        # where it stands still nothing is to follow, unless it must move
        (2, [0, 0, 0, 0.009], {}, True),
        (2, [0, 0, 0, 0.011], {}, False),
        (5, [0, 0, 0, 0], {"must_move": True}, False),
        (2.9, [0, 0, 0, 0.009], {"must_move": True}, True),
        (2.6, [0, 0, 0, 0.009], {"must_move": True}, False),
        # a start to six digits in one convention tells alone, if a half digit is left far away
        ([7, 1, 0.6, 0.6], [0, 0.2, 0.6, 1], {"is_named": True}, True),
        ([7, 1, 0.4, 0.4], [0, 0.2, 0.6, 1], {"is_named": True}, False),
        ([5, 1, 0.6, 0.6], [0, 0.2, 0.2, 0.2], {"is_named": True}, False),
    ],
)
def test_evidence_goes_with_the_motion(digits, moved, how, goes):
    evidence = comparison(digits).evidence
    assert evidence.follows(np.array(moved, dtype=float), **how) is goes


def test_a_fitted_number_follows_a_motion_that_has_gone_twice_as_plainly():
    far = np.array([0, 0.2, 0.6, 1.0])
    for digits, goes in ((1.7, True), (1.5, False)):
        assert comparison(digits, fitted=1).evidence.follows(far) is goes
