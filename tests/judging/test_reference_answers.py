"""What a reference answers: proven, periodic, whole turns, and alone where no form is known."""

import ast
import json
import pickle
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from flint import acb

import polhode
from polhode.cli import main
from polhode.closed_forms.kovalevskaya.theta_attitude import EigenspaceChoice, Moment
from polhode.judging.auxiliary_runs import turning_run
from shared import plain_taylor
from shared.tables import STATE
from shared.tools import exactly, tiers

# -- What the answers say of their proof: in Python, in JSON, and in verdicts


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
    ("euler/separatrix-irrational", (ZERO,)),
    ("grioli/precession", True),
    ("euler/largest-axis", True),
    ("kovalevskaya/delaunay", True),
    ("kovalevskaya/generic", (FORMULA,)),
    ("kovalevskaya/asymptotic", ("the attitude by an enclosure",)),
    ("bobylev-steklov/asymptotic", (ZERO,)),
    ("bobylev-steklov/cn", True),
    ("staude/unstable", True),
    ("steklov/upper", (ZERO,)),
    ("hess/loxodrome", True),
    (IRRATIONAL, (FORMULA, ZERO)),
    ("goryachev-chaplygin/inner-band", ("the attitude by an enclosure",)),
]


@pytest.mark.parametrize(("scene", "said"), tiers(SAID[:2], SAID[2:]))
def test_a_verdict_says_what_is_proven_and_only_proofs_have_radii(
    scene: str | polhode.Scene, said: bool | tuple[str, ...]
) -> None:
    truth = polhode.reference(scene)
    assert isinstance(truth, polhode.Reference)
    rows = [[float(x) for x in row] for row in truth.at([1], 17)]
    judged = polhode.compare(rows, scene, at=[1])
    for claim in (truth.proven, judged.fact("assumed") or judged.fact("proven")):
        if isinstance(said, bool):
            assert claim is said
        else:
            assert isinstance(claim, str)
            assert all(words in claim for words in said)
            assert ("if these" in claim) is (ZERO in said)
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

    def rotated(choice: EigenspaceChoice, moment: Moment) -> tuple[acb, acb]:
        xi, eta = right(choice, moment)
        return xi, -eta

    monkeypatch.setattr(EigenspaceChoice, "at", rotated)
    truth = polhode.reference("kovalevskaya/generic")
    with pytest.raises(polhode.BadInput, match="has not the gamma of the state"):
        truth.attitude([1], 20)


# -- What a reference keeps: a proof to more digits serves a question for fewer


@pytest.mark.parametrize("word", ["at", "attitude"])
def test_a_proof_to_more_digits_is_not_made_again(word: str) -> None:
    proven = polhode.reference(polhode.load("general/asymmetric-regular"), "certified")
    ask = getattr(proven, word)
    rows, agreement = ask([1], 30), proven.agreement
    assert 30 <= agreement < 45
    assert ask([1], 20) == rows  # a proof to 20 digits has other midpoints
    assert proven.agreement == agreement
    assert ask([1], 50) != rows
    assert proven.agreement >= 50
    assert ask([2], 20) != rows


def test_the_agreement_of_a_judgement_is_that_of_its_own_questions() -> None:
    """Of a table of attitudes it was that of states which the reference was asked for before."""
    scene = replace(polhode.load("general/asymmetric-regular"), outputs=("attitude",))
    run = polhode.integrate(scene, at=[1])
    table = {"t": run.t, **{name: run.column(name) for name in ("q0", "q1", "q2", "q3")}}
    proven = polhode.reference(scene, "certified")
    proven.at([1], 5)
    assert polhode.compare(table, proven).agreement == polhode.compare(table, scene).agreement > 15


@pytest.mark.parametrize(("name", "backend"), [("Certified", "certified"), ("Textbook", "mpmath")])
def test_a_deprecated_name_makes_the_same_reference(name: str, backend: str) -> None:
    scene = polhode.load("euler/largest-axis")
    with pytest.warns(DeprecationWarning, match=f"reference\\(scene, '{backend}'\\)"):
        earlier = getattr(polhode, name)(scene)
    assert earlier == polhode.reference(scene, backend)
    assert earlier != polhode.reference(scene)
    assert pickle.loads(pickle.dumps(earlier)) == earlier


def test_what_a_closed_form_alone_tells_is_none_of_an_enclosure() -> None:
    scene = polhode.load("kovalevskaya/generic")
    exact, proven = polhode.reference(scene), polhode.reference(scene, "certified")
    assert exact.frequencies
    assert exact.curve
    assert (proven.frequencies, proven.conditions, proven.rates_of) == ({}, (), {})
    assert proven.period is proven.curve is proven.approach is proven.radii([1]) is None
    rows = [x.column("hodographs", [1], 20)[0] for x in (exact, proven)]
    assert max(abs(x - y) for x, y in zip(*rows, strict=True)) < 1e-19


def test_a_time_may_be_irrational() -> None:
    proven = polhode.reference(polhode.load("euler/largest-axis"), "certified")
    exact = polhode.reference("euler/largest-axis").at(["sqrt(2)"], 30)
    rows = proven.at(["sqrt(2)"], 20)
    assert max(abs(x - y) for x, y in zip(rows[0], exact[0], strict=True)) < 1e-19
    assert proven.at(["sqrt(2)"], 20) == rows


# -- The period of a reference: omega returns after it, and after no part of it, in an integration


DIGITS = 30


def returns(scene, period):
    """By how much omega differs after a period and after parts of it, of the largest omega.

    By an integration, which shares nothing with closed forms.
    """
    first = period / 5
    parts = [period / n for n in (1, 2, 3, 5)]
    times = sorted({first, *(first + part for part in parts)})
    run = polhode.integrate(scene, at=times, digits=DIGITS + 2)
    rows = dict(zip(times, run.states, strict=True))
    size = max(abs(float(x)) for row in rows.values() for x in row[:3])
    differences = []
    for part in parts:
        pairs = zip(rows[first][:3], rows[first + part][:3], strict=True)
        differences.append(max(abs(float(x - y)) for x, y in pairs) / size)
    return differences


@pytest.mark.parametrize(
    "name",
    tiers(
        ["lagrange/planar-librating", "lagrange/steady-slow", "euler/no-gamma"],
        ["lagrange/planar-rotating", "pendulum/librating", "grioli/precession"],
    ),
)
def test_omega_returns_after_the_period(name):
    """It is the true one, and the least."""
    scene = polhode.load(name)
    whole, *parts = returns(scene, abs(exactly(polhode.reference(scene).period)))
    assert whole < 10.0**-DIGITS
    assert min(parts) > 1e-9


def test_a_top_that_nutates_has_no_period_of_omega():
    exact = polhode.reference("lagrange/nutation")
    assert exact.period is None
    assert float(exact.frequencies["nutation"]) == pytest.approx(1.697338005283860772, rel=1e-15)


def test_show_says_what_the_period_is_of(capsys):
    assert main(["show", "lagrange/planar-librating"]) == 0
    assert "period of omega = 9.717146694530" in capsys.readouterr().out
    assert main(["show", "lagrange/nutation"]) == 0
    assert "period" not in capsys.readouterr().out


# -- Angles at times so late that no run tells their turns: judged up to whole turns


SCENE = "euler/turned-symmetric"
TIMES = 0, 1, 10**9


def rows(off=0.0):
    """psi, theta, phi of the attitude, psi off by so much and some whole turns."""
    a, b, c, d = np.array(polhode.reference(SCENE).attitude(TIMES, 30), float).T
    whole, half = np.arctan2(d, a), np.arctan2(c, b)
    theta = 2 * np.arctan2(np.hypot(b, c), np.hypot(a, d))
    return np.array([whole + half + off + 6 * np.pi, theta, whole - half]).T


def test_angles_that_are_refused_are_judged_up_to_whole_turns():
    with pytest.raises(polhode.BadInput, match="ask for the attitude"):
        polhode.reference(SCENE).angles([TIMES[-1]], 20)
    right = polhode.compare(rows(), SCENE, at=TIMES, columns=("psi", "theta", "phi"))
    assert right.parts["angles"] > 14
    wrong = polhode.compare(rows(1e-5), SCENE, at=TIMES, columns=("psi", "theta", "phi"))
    assert 4.9 < wrong.parts["angles"] < 5.1


def test_times_may_be_asked_for_twice_and_in_any_order():
    exact = polhode.reference(SCENE)
    first, second, back = exact.angles([1, 2, -1], 20)
    assert exact.angles([2, -1, 1, 1], 20) == [second, back, first, first]
    judgement = polhode.compare(
        [first, second, first], SCENE, at=[1, 2, 1], columns=("psi", "theta", "phi")
    )
    assert judgement.parts["angles"] > 15


def past_the_pole(miss: str) -> polhode.Reference:
    """A Lagrange top that swings past the upper pole, f - Mz of its spin off by so much."""
    omega = [Fraction(1, 2) + Fraction(5, 3) * Fraction(miss), 2, 3]
    return polhode.reference(
        polhode.top(
            moments=[1, 1, "1/2"], centre=[0, 0, 1], weight=1, omega=omega, gamma=["3/5", 0, "4/5"]
        )
    )


@pytest.mark.parametrize("miss", tiers(["1e-12"], ["1e-16", "-1e-25"]))
def test_the_side_on_which_a_pole_is_passed_is_that_of_the_motion(miss):
    """Nearer than rounding takes a run in double: a branch by it alone is off by a turn."""
    far = past_the_pole("-1e-6" if miss.startswith("-") else "1e-6")
    (row,), (side,) = (top.angles([2], 20) for top in (past_the_pole(miss), far))
    assert [float(x) for x in row] == pytest.approx([float(x) for x in side], abs=1e-4)


@pytest.mark.slow
def test_a_pole_that_is_passed_nearer_than_quad_can_tell_is_no_answer():
    with pytest.raises(polhode.BadInput, match="went round to t = 2 is not known"):
        past_the_pole("1e-36").angles([2], 20)
    assert None not in past_the_pole("0").angles([2], 20)[0]  # through it: either branch


def test_turns_are_not_told_by_a_run_whose_extremes_of_theta_are_not_all_known(monkeypatch):
    """But for a theta that is constant, which has none."""
    exact = polhode.reference("lagrange/nutation")
    assert None not in exact.angles([1], 20)[0]
    assert None not in polhode.reference("lagrange/steady-fast").angles([1], 20)[0]
    right = polhode.EventTimes.__init__

    def incomplete(event, *values, **named):
        right(event, *values, **named)
        object.__setattr__(event, "complete", False)

    monkeypatch.setattr(polhode.EventTimes, "__init__", incomplete)
    with pytest.raises(polhode.BadInput, match="went round to t = 1 is not known"):
        exact.angles([1], 20)


@pytest.mark.slow
def test_a_run_that_leaves_the_motion_tells_no_turns():
    """On the separatrix: rounding takes a run away from it, and there psi is another."""
    exact = polhode.reference("euler/separatrix")
    ((psi, _, phi),) = exact.angles([90], 20)  # by more digits than a double's
    assert (round(float(psi)), round(float(phi))) == (90, 7)
    with pytest.raises(polhode.BadInput, match="went round to t = 230 is not known"):
        exact.angles([5, 230], 20)


def test_a_run_whose_angles_are_others_tells_no_turns(monkeypatch):
    exact = polhode.reference("lagrange/nutation")
    p, q, r = exact.scene.omega
    other = replace(exact.scene, omega=(p, q, r + Fraction(1, 10)))
    monkeypatch.setattr(
        "polhode.judging.reference.turning_run", lambda scene, *args: turning_run(other, *args)
    )
    with pytest.raises(polhode.BadInput, match="went round to t = 1 is not known"):
        exact.angles([1], 20)


# -- The sign of the quaternion at t = 0: its first component that is not 0 is positive


NOT_TURNED = 1e-15
LAGRANGE = {"moments": [1, 1, 2], "centre": [0, 0, 1], "weight": 1}
BODIES = {
    "lagrange": LAGRANGE,
    "euler": {"moments": [1, 2, 3]},
    "kovalevskaya": {"moments": [2, 2, 1], "centre": [1, 0, 0], "weight": 1},
    "general": {"moments": [2, "1.5", 1], "centre": ["0.3", "0.2", "0.5"], "weight": 1},
}


def signs(row) -> str:
    return "".join("0" if abs(x) < NOT_TURNED else "+" if x > 0 else "-" for x in row)


def scene(body: dict, start: dict):
    """One body from one start, with its attitude."""
    omega = ["0.3", "0.2", "1.1"]
    return polhode.top(**body, **start, omega=omega, end=1, samples=2, outputs=["attitude"])


@pytest.mark.parametrize(
    ("body", "start", "expected"),
    tiers(
        [
            ("lagrange", {"angles": ["pi", 0, 0]}, "000+"),
            ("general", {"angles": [0, "pi", 0]}, "0+00"),
            ("kovalevskaya", {"angles": ["-pi/2", 1, "-pi/2"]}, "0+0-"),
            ("euler", {"quaternion": [0, "-3/5", "4/5", 0]}, "0+-0"),
        ],
        [
            ("euler", {"angles": ["pi", 0, 0]}, "000+"),
            ("lagrange", {"angles": ["-pi/3", "pi", 0]}, "0+-0"),
            ("general", {"angles": ["-pi/2", 1, "-pi/2"]}, "0+0-"),
            ("kovalevskaya", {"quaternion": [0, "-3/5", "4/5", 0]}, "0+-0"),
        ],
    ),
    ids=lambda x: getattr(x, "name", None),
)
def test_runs_of_every_type_and_references_agree_where_q0_is_0(body, start, expected):
    """So do runs in the quaternion form, and the closed form if there is one."""
    top = scene(BODIES[body], start)
    rows = {"form": polhode.integrate(replace(top, form="quaternion"), at=[0]).attitude[0]}
    for number in ("double", "extended", "quad", "mp"):
        rows[number] = polhode.integrate(top, number, at=[0]).attitude[0]
    if body != "general":
        rows["reference"] = polhode.reference(top).attitude([0], 20)[0]
    assert {name: signs(row) for name, row in rows.items()} == dict.fromkeys(rows, expected)


@pytest.mark.slow
def test_the_sign_stays_that_of_the_start():
    """Later on, runs, closed forms, enclosures and dense output have no sign of their own."""
    top, times = scene(LAGRANGE, {"angles": ["-pi/2", 1, "-pi/2"]}), [0, 1]
    run = polhode.integrate(top, at=times)
    later = run.attitude[1]
    others = {
        "extended": polhode.integrate(top, "extended", at=times).attitude[1],
        "refined": polhode.integrate(top, "quad", method="refined", at=times).attitude[1],
        "taylor": polhode.integrate(top, "quad", method="taylor", at=times).attitude[1],
        "dense": run.attitude_at([1])[0],
        "closed form": polhode.reference(top).attitude([1], 20)[0],
        "enclosure": polhode.reference(top, "certified").attitude([1], 20)[0],
    }
    assert max(map(abs, later)) > 0.5
    for row in others.values():
        assert max(abs(float(x) - float(y)) for x, y in zip(row, later, strict=True)) < 1e-13


@pytest.mark.parametrize(("side", "last"), [("+", "-"), ("-", "+")])
@pytest.mark.parametrize("digits", [60, 700, 1200])
def test_a_component_that_is_hardly_not_0_decides(digits, side, last):
    """cos(psi/2) at psi = pi +- 10^-digits: of a run and a closed form the same."""
    top = scene(LAGRANGE, {"angles": [f"pi {side} 1e-{digits}", 1, 0]})
    assert signs(polhode.integrate(top, "mp", at=[0]).attitude[0])[3] == last
    assert signs(polhode.reference(top).attitude([0], 20)[0])[3] == last


def test_a_run_in_extended_may_be_its_start_alone():
    run = polhode.integrate("lagrange/nutation", "extended", at=[0])
    assert run.times == (0,)
    assert run(0)[0] == run.states[0][0]


# -- Every case without a closed form against an integrator that shares nothing with polhode


DIGITS_OF_SERIES = 40
ANGLE = 6  # how far each motion is followed, in radians


def followed(name: str):
    """A case at two times within the angle, and its motion by the plain series, twice."""
    scene = replace(polhode.load(name), outputs=(), events=(), published=())
    end = scene.end * min(Fraction(1), Fraction(round(ANGLE * 100 / 10**scene.log10_angle), 100))
    times = (end / 3, end)
    scene = replace(scene, times=times)
    numbers = scene.body.moments, scene.body.torque, scene.omega, scene.gamma
    rows = plain_taylor.integrate(*numbers, times, DIGITS_OF_SERIES)
    finer = plain_taylor.integrate(*numbers, times, DIGITS_OF_SERIES + 10)
    assert off(rows, finer) < Fraction(1, 10 ** (DIGITS_OF_SERIES - 4))
    return scene, finer


def off(rows, true) -> Fraction:
    return max(
        abs(exactly(x) - y)
        for row, right_row in zip(rows, true, strict=True)
        for x, y in zip(row, right_row, strict=True)
    )


@pytest.mark.slow
def test_a_motion_without_a_closed_form_is_that_of_the_plain_series() -> None:
    """The enclosure holds the motion, and runs in quad are right as far as quad goes."""
    scene, true = followed("general/asymmetric-chaotic")
    proof = polhode.certify(scene, at=scene.times, digits=20)
    for row, middles, radii in zip(true, proof.centres, proof.radii, strict=True):
        for x, middle, radius in zip(row, middles, radii, strict=True):
            assert abs(x - middle) <= Fraction(radius)
    for method, least in (("refined", 31), ("taylor", 29)):
        run = polhode.integrate(scene, "quad", method=method)
        assert Fraction(1, 10**37) < off(run.states, true) < Fraction(1, 10**least)


def test_the_plain_series_imports_nothing_of_polhode_and_is_short():
    text = Path(plain_taylor.__file__).read_text()
    assert len(text.splitlines()) < 100
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module)
    assert names == {"collections.abc", "fractions", "functools", "typing", "mpmath"}


def test_the_plain_series_is_exact_on_a_motion_that_is_known():
    """A symmetric free body: p + iq turns with (C - A)/A r."""
    body, start = ([2, 2, 1], [0, 0, 0]), ([1, 0, 3], [0, 0, 1])
    numbers = [[Fraction(x) for x in part] for part in (*body, *start)]
    (row,) = plain_taylor.integrate(*numbers, [Fraction(7)], DIGITS_OF_SERIES)
    with mpmath.workdps(60):
        angle = mpmath.mpf(-3) / 2 * 7
        for x, y in zip(row[:3], (mpmath.cos(angle), mpmath.sin(angle), 3), strict=True):
            assert (
                abs(mpmath.mpf(x.numerator) / x.denominator - y)
                < mpmath.mpf(10) ** -DIGITS_OF_SERIES
            )
