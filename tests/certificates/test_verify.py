"""Certificates of states and attitudes: what is true is proved by code of its own, what is false
never."""

import ast
import copy
import itertools
import json
import random
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
from flint import arb, arb_mat, arb_poly, ctx, fmpq

import polhode
from polhode import BadInput
from polhode.certificates import verify
from polhode.cli import main
from shared.proofs import body_of
from shared.tools import CHECKER, altered, answer, of_table, python, tiers

REGULAR = "general/asymmetric-regular"
PARTS = {"balls": slice(6), "attitude": slice(6, 10)}


def scene_of(name, with_attitude=True):
    return replace(polhode.load(name), outputs=("attitude",) if with_attitude else ())


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The states of an asymmetric body to t = 1, 20 digits."""
    return saved_certificate(tmp_path_factory, with_attitude=False)


@pytest.fixture(scope="module")
def with_turns(tmp_path_factory):
    """The same with its attitude."""
    return saved_certificate(tmp_path_factory, with_attitude=True)


def saved_certificate(folders, with_attitude):
    path = folders.mktemp("certificates") / "proof.json"
    polhode.certify(scene_of(REGULAR, with_attitude), at=["1/2", 1], digits=20).save(path)
    return json.loads(path.read_text())


def holds(certificate):
    """Whether a certificate is proved; it may be damaged, too."""
    return not answer(certificate).startswith("refused")


@pytest.mark.parametrize(
    ("name", "at", "digits", "has_attitude"),
    tiers(
        [("lagrange/turned-axes", [1], 20, True)],
        [
            ("general/asymmetric-chaotic", [1], 40, True),
            ("hard/very-fast-top", ["0.00001"], 16, True),
            ("kovalevskaya/generic", [-1], 16, True),
            ("published/hairer-vilmart", [1], 20, True),  # from the pole
            ("steklov/upper", [0, 1], 16, True),  # irrational data, and a time 0
        ],
    ),
)
def test_what_is_certified_is_proved_by_the_file_alone(name, at, digits, has_attitude, tmp_path):
    path = tmp_path / "proof.json"
    polhode.certify(scene_of(name, has_attitude), at=at, digits=digits).save(path)
    ran = python("-I", str(CHECKER), str(path))
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout == polhode.verify(path).text + "\n"
    assert ("its attitude" in ran.stdout) == has_attitude


def test_irrational_data_and_units_far_from_one(tmp_path):
    for unit in (Fraction(1), Fraction(10) ** 20, Fraction(1, 10**20)):
        top = polhode.top(
            moments=[2, "sqrt(2)", 1],
            centre=["1/3", 0, "sqrt(3)/2"],
            weight=unit * unit,
            omega=[unit / 7, 0, unit],
            gamma=["3/5", 0, "4/5"],
        )
        path = tmp_path / f"{float(unit)}.json"
        polhode.certify(top, at=[2 / unit], digits=16).save(path)
        assert polhode.verify(path).proved


def test_it_is_the_attitude_of_a_run(with_turns):
    run = polhode.integrate(scene_of(REGULAR), "quad", at=["1/2", 1])
    for row, claim in zip(run.attitude, with_turns["statement"], strict=True):
        for x, (middle, radius) in zip(row, claim["attitude"], strict=True):
            off = abs(Fraction(str(x)) - Fraction(middle))
            assert off <= Fraction(radius) + Fraction(1, 10**30)


# -- the file alone -------------------------------------------------------------------------------


def test_it_shares_no_code():
    """Nothing but the standard library and python-flint."""
    tree = ast.parse(CHECKER.read_text(encoding="utf-8"))
    names = [alias.name for x in ast.walk(tree) if isinstance(x, ast.Import) for alias in x.names]
    names += [x.module or "." for x in ast.walk(tree) if isinstance(x, ast.ImportFrom)]
    assert "flint" in names
    assert {name.partition(".")[0] for name in names} - {"flint"} <= {*sys.stdlib_module_names}


def test_without_flint_it_says_so_and_proves_nothing(tmp_path):
    (tmp_path / "flint.py").write_text("raise ImportError\n")
    ran = python(str(CHECKER), "x.cert", env={"PYTHONPATH": str(tmp_path)}, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr == "python-flint is needed: pip install python-flint\n"


@pytest.mark.slow
def test_a_certificate_from_the_standard_input(small):
    for command in ([str(CHECKER), "-"], ["-m", "polhode", "verify", "-"]):
        ran = python(*command, input=json.dumps(small))
        assert ran.returncode == 0, ran.stderr
        assert "proved: at 2 times" in ran.stdout


# -- what is false --------------------------------------------------------------------------------


def moved_off(certificate, row, key, column, by=2):
    """The certificate with one ball moved by some of its radii."""

    def moved(ball):
        return [str(Fraction(ball[0]) + by * Fraction(ball[1])), ball[1]]

    row %= len(certificate["statement"])
    return altered(certificate, f"statement {row} {key} {column}", moved)


@pytest.mark.slow
def test_a_ball_that_is_moved_off_is_not_proved(with_turns):
    assert holds(with_turns)
    for column in range(6):
        assert not holds(moved_off(with_turns, 0, "balls", column))


def test_a_ball_at_the_start_holds_the_start_or_is_refused(small):
    start = [*small["scene"]["omega"], *small["scene"]["gamma"]]
    first = {"t": "0", "balls": [[x, "1e-30"] for x in start]}
    certificate = small | {"statement": [first, *small["statement"]]}
    assert holds(certificate)
    for k in range(6):
        assert not holds(moved_off(certificate, 0, "balls", k))
    for radius, inside in (("5e-31", True), ("2e-30", False)):  # of the start itself
        wide = altered(certificate, "scene omega 0", lambda x, r=radius: [x, r])
        assert holds(wide) == inside
    assert not holds(altered(small, "scene omega 0", lambda x: [x, "1e-9"]))


def test_the_largest_radius_is_told(small):
    assert "of radius 1.0e-09 at most" in answer(altered(small, "statement 0 balls 2 1", "1e-9"))


def minus(x):
    middle, *radius = x if isinstance(x, list) else [x]
    return [str(-Fraction(middle)), *radius] if radius else str(-Fraction(middle))


def larger(x):
    """A number off by one part in 10^20, of balls of 10^-22."""
    return str(Fraction(x) * Fraction(10**20 + 1, 10**20))


#: Another scene than the certificate's: what is done to it.
OTHERS = {
    **{f"{key} 0": larger for key in ("moments", "centre", "omega", "gamma")},
    "weight": larger,
    # the same rotation, but the statement tells of the other quaternion
    "attitude": lambda attitude: [minus(x) for x in attitude],
}


@pytest.mark.parametrize("place", OTHERS)
def test_another_scene_is_not_proved(with_turns, place):
    assert not holds(altered(with_turns, f"scene {place}", OTHERS[place]))


def test_a_start_that_turns_the_vertical_elsewhere_is_told(with_turns):
    turned = altered(with_turns, "scene attitude", ["0.6", "0", "0.8", "0"])
    assert "another gamma" in answer(turned)


@pytest.mark.slow
def test_guesses_prove_nothing_false(with_turns):
    """Whatever they are: the same true statement, or nothing."""
    chance = random.Random(5)
    near, few, more = (copy.deepcopy(with_turns) for _ in range(3))
    for row in near["centres"]:
        row[chance.randrange(6)] += chance.randrange(-(2 ** chance.randrange(60)), 2**40)
    k = chance.randrange(1, len(few["grid"]) - 1)
    del few["grid"][k], few["centres"][k]
    more["bits"] += 100
    proved = 0
    for certificate in (near, few, more):
        proved += holds(certificate)
        assert not holds(moved_off(certificate, -1, "balls", 0, 3))
        assert not holds(moved_off(certificate, -1, "attitude", 2, 3))
    assert proved > 0


def test_errors_of_the_start_are_carried_on(with_turns, monkeypatch):
    certificate = copy.deepcopy(with_turns)
    first = [Fraction(x[0] if isinstance(x, list) else x) for x in certificate["scene"]["attitude"]]
    angle = Fraction(1, 10**9)  # the same gamma within the balls, turned about the vertical
    quaternion = [first[0] - angle * first[3], first[1] - angle * first[2]]
    quaternion += [first[2] + angle * first[1], first[3] + angle * first[0]]
    certificate["scene"]["attitude"] = [[str(x), "2e-9"] for x in quaternion]
    assert 1e-3 < worst(certificate, monkeypatch, "attitude") < 1


def worst(certificate, monkeypatch, key):
    """How far the truth lies from the middle of the checker's balls at the last time, in radii."""
    rows = []
    with monkeypatch.context() as patch, ctx.workprec(64):
        patch.setattr(verify, "_check", lambda _, there: rows.append(there))
        verify.state(certificate)
    truth = [Fraction(middle) for middle, _ in certificate["statement"][-1][key]]
    with ctx.workprec(300):
        return max(
            float(abs(x.mid() - arb(fmpq(y.numerator, y.denominator))).mid() / x.rad())
            for x, y in zip(rows[-1][PARTS[key]], truth, strict=True)
        )


#: Guesses that are far from the truth, and the balls that have to hold it.
FAULTS = {
    **dict.fromkeys(("taylor", "no next_of_v", "next_of_v", "rough centres"), "balls"),
    **dict.fromkeys(("taylor of the turn", "rough centres of the turn"), "attitude"),
}


def faulty(fault, certificate, patch):
    """A certificate or a checker with such guesses."""
    function = fault.removeprefix("no ").removesuffix(" of the turn")
    if not fault.startswith("rough"):
        guess = getattr(verify, function)

        def wrong(*arguments):
            rows = guess(*arguments)
            if function == "next_of_v":
                if fault.startswith("no"):
                    return rows * arb(0)
                return (rows * arb("1.001")).mid() if arguments[1] == 0 else rows
            rows[8 if fault.endswith("turn") else 2][3] += arb("1e-12").mid()
            return rows

        patch.setattr(verify, function, wrong)
    if function == "next_of_v":
        off = 2**40 if fault == function else 2**8
        certificate["centres"] = [[x + off for x in row] for row in certificate["centres"]]
    elif fault.startswith("rough"):
        cut = certificate["state_bits"] - 18
        certificate["centres"] = [[x >> cut for x in row] for row in certificate["centres"]]
        certificate["state_bits"] = 18


@pytest.mark.parametrize("fault", of_table(FAULTS, "taylor", "no next_of_v"))
def test_faulty_guesses_are_contained(fault, request, monkeypatch):
    key = FAULTS[fault]
    certificate = copy.deepcopy(
        request.getfixturevalue("small" if key == "balls" else "with_turns")
    )
    faulty(fault, certificate, monkeypatch)
    ratio = worst(certificate | {"statement": certificate["statement"][:1]}, monkeypatch, key)
    assert 1e-7 < ratio < 1  # a bound that is far too wide would tell nothing


PULL = (0.25, -0.5, 0.125)


@pytest.mark.parametrize("moments", [(1, 1, 1), (3, 2, 2), (8, 7, 1), (1, 8, 2)])
def test_the_quadratic_part_of_the_rates_is_bounded_sharply(moments):
    """By its values where every component is 1 or -1: half the sum of f there and opposite."""
    largest = 0.0
    with ctx.workprec(64):
        body = body_of(moments, PULL)
        for signs in itertools.product((1, -1), repeat=6):
            here, there = (verify.rates(body, [arb(side * x) for x in signs]) for side in (1, -1))
            both = [float(abs(x + y)) / 2 for x, y in zip(here, there, strict=True)]
            largest = max(largest, *both)
    assert float(body.beta) == pytest.approx(largest, rel=1e-12)


def test_what_v_misses_is_bounded_beyond_its_last_coefficient_too(monkeypatch):
    transition, matrices = verify.transition, []
    monkeypatch.setattr(verify, "MOST_TERMS", 3)
    monkeypatch.setattr(
        verify, "transition", lambda a, *rest: matrices.append(a) or transition(a, *rest)
    )
    with ctx.workprec(64):
        start = [arb(x) for x in ("0.5", "-0.25", "1", "0", "0.75", "0.5")]
        step = verify.Step(body_of((3, 2, 1), PULL), start, arb("0.125"), 64, verify.STATES)
        (a,), v, norms = matrices, step.v, []
        for k in range(len(a) + len(v)):
            total = v[k + 1] * arb(-(k + 1)) if k + 1 < len(v) else arb_mat(6, 6)
            for j, matrix in enumerate(a):
                total += matrix * v[k - j] if 0 <= k - j < len(v) else arb_mat(6, 6)
            norms.append(verify.row_sum(total.table()))
        missed, bound = float(verify.integral(norms)), float(step.rho / step.growth)
    assert missed <= bound < 6 * missed


@pytest.mark.parametrize(
    ("coefficients", "terms", "missed", "slack"),
    [
        # V = 1 to the degree that is tried
        ((0, 0, 1), 120, 1 / 3, 1.02),
        # V = 1 + 10 tau + 50 tau^2: A V - V' is 10^6 tau^2 V
        ((10, 0, 10**6), 3, 10**6 * (1 / 3 + 10 / 4 + 50 / 5), 6),
    ],
)
def test_what_v_misses_is_bounded(coefficients, terms, missed, slack, monkeypatch):
    """Of an A with these coefficients in its first entry, which begins late, or grows."""
    monkeypatch.setattr(verify, "MOST_TERMS", terms)
    with ctx.workprec(64):
        a = verify.matrices_of({(0, 0): arb_poly([*coefficients])}, arb(1))
        v, bound = verify.transition(a, [verify.row_sum(x.table()) for x in a], verify.SETS)
    assert (coefficients[0] == 0) == all(x == arb_mat(6, 6) for x in v[1:])
    assert missed * (1 - 1e-15) <= float(bound) < slack * missed


def test_a_body_at_rest_without_weight_and_vertical_stays_where_it_is():
    # f' is 0 along it: A has no coefficients
    scene = {"moments": [1, 2, 3], "centre": [0] * 3, "weight": 0, "omega": [0] * 3}
    claim = {"t": "1/2", "balls": [[0, "1e-9"]] * 6}
    guesses = {"time_bits": 10, "grid": [0, 512], "state_bits": 10, "centres": [[0] * 6]}
    certificate = guesses | {"format": "polhode certificate 1", "kind": "state", "bits": 64}
    certificate |= {"scene": scene | {"gamma": [0] * 3}}
    assert holds(certificate | {"statement": [claim]})


# -- what is no certificate -----------------------------------------------------------------------


def lopsided(scene):
    """A scene whose matrix of inertia has one product of inertia, not two."""
    rows = {"inertia": [["2", "1/10", "0"], ["0", "3/2", "0"], ["0", "0", "1"]]}
    return rows | {key: x for key, x in scene.items() if key != "moments"}


def without(key):
    """A list without its last value, or a table without a key."""
    return lambda x: x[:-1] if isinstance(x, list) else {k: x[k] for k in x if k != key}


def with_more(**more):
    return lambda table: table | more


#: A place, what stands there then or is made of it, and what is said.
DAMAGED = [
    ("format", "another", "expected the format"),
    ("kind", "orbit ", "kind: expected"),
    ("scene", {"moments": ["2", "3/2", "1"]}, "scene: expected"),
    ("scene", without("attitude"), "expected attitude"),
    ("scene", with_more(damping="0"), "nothing else"),
    ("scene", with_more(omega=[["1", "-1e-30"], 0, 0]), "not negative"),
    ("scene", lopsided, "a symmetric matrix"),
    ("scene attitude", without(-1), "a list of 4"),
    ("time_bits", 10**9, "time_bits"),
    ("state_bits", "100", "state_bits"),
    ("bits", 10**9, "bits"),
    ("bits", 10, "bits"),
    ("grid", [0], "grid"),
    ("grid", [1, 2], "grid"),
    ("grid", [0, 5, 3], "grid"),
    ("grid", lambda grid: [t + 5 for t in grid], "expected 0 and up to"),
    ("statement", [{"t": "1", "balls": []}], "statement[0]"),
    ("statement", [{"t": "nan", "balls": [["0", "1"]] * 6}], "statement[0].t"),
    ("statement 0 balls 0 1", "-1", "not negative"),
    ("statement 0 t", "1000", "outside"),
    ("statement 0 attitude", without(-1), "a list of 4"),
    ("statement 0", with_more(turn=[]), "nothing else"),
]


@pytest.mark.parametrize(("place", "value", "said"), DAMAGED)
def test_what_is_damaged_is_told(with_turns, place, value, said):
    text = answer(altered(with_turns, place, value))
    assert text.startswith("refused: ")
    assert "\n" not in text
    assert said in text


def test_work_that_would_take_hours_is_refused(with_turns):
    more = {"bits": 4000, "grid": [*range(10_000)], "centres": [with_turns["centres"][0]] * 9_999}
    assert "are too many" in answer(with_turns | more)


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", "{", "{}", "[" * 100_000, "1" * 10_000),
        *('{"a": 1, "a": 1}', '{"a": 1.5}', '{"a": NaN}'),
    ],
)
def test_a_damaged_file_is_one_line(text, tmp_path):
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(BadInput, match="certificate"):
        polhode.verify(path)


def test_a_key_that_stands_twice_is_told(small, tmp_path):
    """Though both say the same, and though all is proved by the second one."""
    path = tmp_path / "x.json"
    path.write_text(json.dumps(small)[:-1] + ', "kind": "state"}')
    with pytest.raises(BadInput, match="a key stands twice"):
        polhode.verify(path)


def test_numbers_longer_than_python_reads_are_read(small, tmp_path):
    """4300 digits are Python's own limit; beyond the checker's one line tells."""
    path = tmp_path / "x.json"
    text = json.dumps(small)
    first = json.dumps(small["centres"][0][0])
    path.write_text(text.replace(first, "1" * 5000, 1))
    assert "condition of the step" in polhode.verify(path).text
    path.write_text(text.replace(first, "1" * 30_000, 1))
    with pytest.raises(BadInput, match=r"centres\[0\]\[0\]: .* at most 20000 bits"):
        polhode.verify(path)
    middle, _ = small["statement"][0]["balls"][0]
    longer = middle + "0" * 5000
    path.write_text(text.replace(json.dumps(middle), json.dumps(longer), 1))
    assert polhode.verify(path).proved


# -- doors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("digits", "outputs"), tiers([(16, [])], [(20, ["--outputs", "attitude"])])
)
def test_the_command_line(digits, outputs, tmp_path, capsys):
    path = tmp_path / "proof.json"
    command = ["certify", REGULAR, "--at", "1", "--digits", str(digits), *outputs]
    assert main([*command, "-o", str(path)]) == 0
    assert "digits_proven" in capsys.readouterr().out
    assert main(["verify", str(path), "--json"]) == 0
    out = capsys.readouterr().out
    answer = json.loads(out)
    assert answer["proven"] is True
    assert ("at 1 its attitude" in out) == bool(outputs)
    certificate = json.loads(path.read_text())
    certificate["statement"][0]["balls"][0][0] = "0.5"
    path.write_text(json.dumps(certificate))
    assert main(["verify", str(path)]) == 1
    assert "p at t = 1 is not shown to lie in its ball" in capsys.readouterr().out


def test_a_certificate_on_stdout_is_alone(capsys):
    command = ["certify", "lagrange/nutation", "--at", "1", "--digits", "10"]
    assert main([*command, "-o", "-"]) == 0
    output = capsys.readouterr()
    assert json.loads(output.out)["kind"] == "state"
    assert "every digit is proven" in output.err


@pytest.mark.slow
def test_the_progress_of_a_certificate_is_that_of_guesses_and_check_together(tmp_path):
    """The check counted from 0 again: forecasts were too short during the one, too long after."""
    parts = []
    enclosure = polhode.certify("lagrange/nutation", at=[2], digits=15)
    enclosure.save(tmp_path / "x.json", lambda fraction, steps: parts.append((fraction, steps)))
    fractions = [fraction for fraction, _ in parts]
    assert fractions == sorted(fractions)
    begin = [steps for _, steps in parts].index(0, 1)  # of the check
    assert fractions[0] == 0
    assert fractions[begin - 1] < 0.2 <= fractions[begin] < 0.3  # a fifth is that of the guesses
    assert 0.9 < fractions[-1] <= 1


def test_progress_is_told(small, tmp_path):
    fractions = []
    (path := tmp_path / "x.json").write_text(json.dumps(small))
    polhode.verify(path, lambda part, steps: fractions.append((part, steps)))
    assert fractions[0] == (0.0, 0)
    assert [steps for _, steps in fractions] == list(range(len(small["centres"])))
    assert all(0 <= part < 1 for part, _ in fractions)


@pytest.mark.parametrize(
    ("scene", "at", "said"),
    [
        ("euler/largest-axis", [0], "a time other than 0"),
        ("lagrange/nutation", [-1, 1], "times of one sign"),
        ("lagrange/nutation", ["sqrt(2)"], "rational times"),
    ],
)
def test_what_has_no_certificate_is_refused(scene, at, said, tmp_path):
    with pytest.raises(BadInput, match=said):
        polhode.certify(scene, at=at, digits=10).save(tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()
