"""A number that explains a table: found where one was changed, and nowhere else."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.judging.diagnosis import causes
from polhode.scenes.body import Body
from shared.mutation import without

TIMES = [Fraction(k, 4) for k in range(61)]
NAMES = (
    *("lagrange/nutation", "kovalevskaya/generic", "euler/largest-axis"),
    *("general/asymmetric-regular", "general/asymmetric-chaotic"),
)
HEAVY = [name for name in NAMES if polhode.load(name).body.weight]


def scene(name):
    return replace(polhode.load(name), events=(), outputs=())


def table(scene, times=TIMES):
    run = polhode.integrate(scene, at=times)
    states = np.array(run.states, dtype=float)
    return {"t": np.array(TIMES, dtype=float), **dict(zip(scene.columns, states.T, strict=True))}


def with_body(name, moment=None, centre=None, weight=Fraction(1)):
    own = scene(name)
    inertia = [[*row] for row in own.body.inertia]
    middle = [*own.body.centre]
    if moment is not None:
        inertia[moment][moment] *= Fraction(102, 100)
    if centre is not None:
        middle[centre] += Fraction(1, 50)
    return replace(own, body=Body(inertia, middle, own.body.weight * weight))


def found(columns, name):
    judged = polhode.compare(columns, scene(name))
    assert judged.worst < 5
    return judged


def number(text):
    return float(re.search(r"(?:= |t \+ |of )([-+.\de]+)", text)[1])


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("moment", range(3))
def test_another_moment_is_found_to_its_digits(name, moment):
    other = with_body(name, moment)
    first = found(table(other), name).causes[0]
    letter = "ABC"[moment]
    assert first.words.startswith(f"the moment {letter} = ")
    true = float(other.body.inertia[moment][moment])
    assert number(first.words) == pytest.approx(true, rel=1e-9)
    assert first.digits > 11


@pytest.mark.parametrize("name", ["lagrange/nutation", "kovalevskaya/generic"])
def test_equal_moments_are_fitted_together(name):
    """A wrong symmetric top stays one."""
    own = scene(name)
    inertia = [[*row] for row in own.body.inertia]
    for i in range(2):
        inertia[i][i] *= Fraction(102, 100)
    other = replace(own, body=Body(inertia, own.body.centre, own.body.weight))
    first = found(table(other), name).causes[0]
    assert first.words.startswith("the moments A = B = ")
    assert f"(the scene's are {float(own.body.inertia[0][0]):g})" in first.words
    assert number(first.words.replace("A = B", "A")) == pytest.approx(
        float(inertia[0][0]), rel=1e-9
    )
    assert first.digits > 11


FULL = [["1.3", "0.1", "-0.2"], ["0.1", "1.1", "0.15"], ["-0.2", "0.15", "0.9"]]


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("i", "j", "value"), [(0, 1, "0.12"), (2, 2, "0.93"), (0, 0, "1.27"), (1, 2, "0.1")]
)
def test_another_element_of_a_full_tensor_is_found(i, j, value):
    def of(inertia):
        start = {"omega": ["0.5", "1.2", "-0.7"], "gamma": ["0.6", 0, "0.8"]}
        return polhode.top(inertia=inertia, centre=["0.1", "0.2", "0.3"], weight="1.5", **start)

    other = [[*row] for row in FULL]
    other[i][j] = other[j][i] = value
    times = [Fraction(k, 4) for k in range(25)]
    run = polhode.integrate(of(other), at=times)
    columns = {"t": run.t, **dict(zip(run.columns, np.array(run.states).T, strict=True))}
    (first, *_) = polhode.compare(columns, of(FULL)).causes
    element = f"the element {'xyz'[i]}{'xyz'[j]} of inertia = "
    assert first.words.startswith(element)
    assert first.words.endswith(f"(the scene's is {float(FULL[i][j]):g})")
    assert number(first.words) == pytest.approx(float(value), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", HEAVY)
def test_another_weight_or_centre_is_found(name):
    told = found(table(with_body(name, weight=Fraction(981, 1000))), name).causes
    assert any("a weight, or a distance" in one.words for one in told)
    assert number(told[0].words) == pytest.approx(0.981, rel=1e-9)
    for axis in range(3):
        other = with_body(name, centre=axis)
        told = found(table(other), name).causes
        words = f"the centre's {'xyz'[axis]} = "
        (one,) = (one for one in told if one.words.startswith(words))
        assert number(one.words) == pytest.approx(float(other.body.centre[axis]), abs=1e-9)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("place", range(3))
def test_another_start_is_found(name, place):
    own = scene(name)
    omega = [*own.omega]
    omega[place] += Fraction(1, 100)
    told = found(table(replace(own, omega=tuple(omega))), name).causes
    (one,) = (one for one in told if one.words.startswith("pqr"[place]))
    assert number(one.words) == pytest.approx(float(omega[place]), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_another_clock_is_found(name):
    own = scene(name)
    late = found(table(own, [t + Fraction(1, 70) for t in TIMES]), name).causes[0]
    assert late.words.startswith("rows that belong to t + ")
    assert number(late.words) == pytest.approx(1 / 70, rel=1e-9)
    fast = found(table(own, [t * Fraction(1001, 1000) for t in TIMES]), name).causes
    (one,) = (one for one in fast if "the pace" in one.words)
    assert number(one.words) == pytest.approx(1.001, rel=1e-9)
    columns, later = table(own), table(own, [t + Fraction(1, 80) for t in TIMES])
    half = columns | {x: later[x] for x in "pqr"}
    told = found(half, name).causes
    assert [one.words.partition(" that")[0] for one in told][:1] in (["omega"], ["gamma"], ["rows"])


# -- methods, which no number explains --------------------------------------------------------


def euler(f, y, h):
    return y + h * f(0, y)


def midpoint(f, y, h):
    return y + h * f(0, y + h / 2 * f(0, y))


def heun(f, y, h):
    a = f(0, y)
    return y + h / 2 * (a + f(0, y + h * a))


def rk4(f, y, h):
    a = f(0, y)
    b = f(0, y + h / 2 * a)
    c = f(0, y + h / 2 * b)
    return y + h / 6 * (a + 2 * b + 2 * c + f(0, y + h * c))


def implicit_midpoint(f, y, h):
    z = y
    for _ in range(30):
        z = y + h * f(0, (y + z) / 2)
    return z


METHODS = {
    "euler": (euler, 400),
    "midpoint": (midpoint, 20),
    "heun": (heun, 20),
    "rk4": (rk4, 4),
    "implicit midpoint": (implicit_midpoint, 20),
}


def stepped(name, method, count, end=15):
    f = polhode.field(scene(name))
    y, rows = np.array(f.start), [f.start]
    times = [k / 4 for k in range(4 * end + 1)]
    for _ in times[1:]:
        for _ in range(count):
            y = method(f, y, 0.25 / count)
        rows.append(y)
    columns = scene(name).columns
    return {"t": np.array(times), **dict(zip(columns, np.array(rows).T, strict=True))}


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_a_rough_method_is_explained_by_nothing(name, method):
    judged = polhode.compare(stepped(name, *METHODS[method]), scene(name))
    assert judged.worst < 9
    assert judged.causes == ()


@pytest.mark.slow
def test_a_small_difference_that_a_method_may_have_is_not_told(monkeypatch):
    name = "lagrange/nutation"
    own = scene(name)
    body = replace(own.body, weight=own.body.weight * (1 + Fraction(1, 10**6)))
    columns = table(replace(own, body=body))
    assert polhode.compare(columns, own).causes == ()
    monkeypatch.setattr(causes, "LEAST", 1e-8)
    assert polhode.compare(columns, own).causes != ()


@pytest.mark.slow
def test_noise_and_nonsense_are_explained_by_nothing():
    rng = np.random.default_rng(3)
    for name in NAMES[:2]:
        columns = table(scene(name))
        noisy = {x: v + 1e-4 * rng.standard_normal(v.shape) for x, v in columns.items()}
        assert polhode.compare(noisy | {"t": columns["t"]}, scene(name)).causes == ()
        wild = {x: rng.standard_normal(v.shape) for x, v in columns.items()}
        assert polhode.compare(wild | {"t": columns["t"]}, scene(name)).causes == ()


@pytest.mark.slow
def test_two_wrong_numbers_are_not_explained_by_one():
    own = with_body("kovalevskaya/generic", moment=2)
    own = replace(own, omega=(own.omega[0] + Fraction(1, 100), *own.omega[1:]))
    assert found(table(own), "kovalevskaya/generic").causes == ()


def test_a_right_table_another_convention_and_a_run_have_no_causes():
    own = scene("lagrange/nutation")
    columns = table(own)
    assert polhode.compare(columns, own).causes == ()
    swapped = columns | {"p": columns["q"], "q": columns["p"]}
    assert polhode.compare(swapped, own).causes == ()
    loose = polhode.integrate(own, at=TIMES, tol=1e-5, method="taylor")
    assert polhode.compare(loose).causes == ()


@pytest.mark.slow
def test_a_cause_is_printed_and_in_json(tmp_path, capsys):
    name = "lagrange/nutation"
    columns = table(with_body(name, moment=2))
    rows = zip(*columns.values(), strict=True)
    text = "\n".join([",".join(columns), *(",".join(map(repr, map(float, r))) for r in rows)])
    path = tmp_path / "x.csv"
    path.write_text(text)
    assert main(["compare", str(path), name]) == 0
    line = "explained by the moment C = 0.51 (the scene's is 0.5), which gives 15.0 digits"
    text = capsys.readouterr().out
    assert line in text.splitlines()
    assert "no limit is named, since another number explains the error" in text
    assert "limited by" not in text
    assert main(["compare", str(path), name, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["causes"]
    assert told[0] == {"cause": "the moment C = 0.51 (the scene's is 0.5)", "digits": 15.0}


def test_a_fit_that_forgets_its_digits_is_noticed():
    columns = table(with_body("lagrange/nutation", moment=2))
    with without(
        causes, "Fit.fitted", "step = -float(slope @ error)", "step = float(slope @ error)"
    ):
        assert found(columns, "lagrange/nutation").causes == ()
