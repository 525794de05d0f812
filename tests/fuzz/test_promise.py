"""Whatever is given, the promise is kept: cases that hypothesis makes, see :mod:`fuzz.promise`.

A class of cases is a strategy.  By hand, many of each: pytest -m campaign tests/fuzz.
"""

from __future__ import annotations

import contextlib
import io
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

import polhode
from fuzz import cases, changed_files, motions, promise
from polhode import cli
from polhode.numbers.mpmath_context import mpf, mpmath, own
from polhode.output import description
from shared import plain_taylor
from shared.closed_form_motions import number
from shared.results import MAKERS

#: Kinds of results that take little to make, a run in quad among them.
FEW = ("Trajectory in quad", "Ensemble", "Judgement", "Enclosure", "Reductions", "Lyapunov")

#: Strategies, and how many cases of each a slow test and the campaign try.
CLASSES = {
    "scene": (cases.scene(), 40, 6000),
    "call": (cases.call(), 75, 6000),
    "toml": (cases.toml(), 20, 2000),
    "table": (cases.table(), 10, 1000),
    "command": (cases.command(), 20, 2000),
    "result": (changed_files.result(FEW), 20, 0),
    "any result": (changed_files.result([*MAKERS]), 0, 6000),
    "kept": (changed_files.kept(), 8, 500),
    "body": (motions.body(), 15, 2000),
    "event": (motions.event(), 5, 500),
    "proof": (motions.proof(), 3, 50),
}
HOW = {"database": None, "suppress_health_check": [*HealthCheck]}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cases.prepared(tmp_path)
    monkeypatch.setattr(description, "SECONDS", 0.05)  # that show looks for frequencies


def keep(case: cases.Case) -> int | bool | None:
    """Its exit code, or whether it was refused; the promise is kept."""
    cases.prepared(Path())
    for name, text in case.files.items():
        Path(name).write_bytes(text)
    if isinstance(case.work, list):
        faults, end = promise.of_command(case.work)
    else:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            faults, end = promise.of_call(case.work)
    assert not faults, "\n".join(faults)
    return end


def many(kind: str, count: int) -> set[int | bool | None]:
    """So many cases of a class, and how they ended."""
    ends = set()

    @settings(max_examples=count, **HOW)
    @given(CLASSES[kind][0])
    def kept(case: cases.Case) -> None:
        ends.add(keep(case))

    kept()
    return ends


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in CLASSES if CLASSES[kind][1]])
def test_the_promise_is_kept(kind):
    ends = many(kind, CLASSES[kind][1])
    if kind in ("scene", "call"):  # what is refused is made, and what is not
        assert len(ends) >= 2


@pytest.mark.parametrize("kind", ["scene", "toml"])
def test_the_promise_is_kept_by_some_texts(kind):
    many(kind, 4)


@pytest.mark.campaign
@pytest.mark.parametrize("kind", [kind for kind in CLASSES if CLASSES[kind][2]])
def test_the_promise_is_kept_in_many_cases(kind):
    many(kind, CLASSES[kind][2])


@pytest.mark.sample(3, slow=4)
@pytest.mark.filterwarnings("ignore")  # those of matplotlib's own, of numbers like these
@pytest.mark.parametrize(
    "words",
    [
        *("run x.toml", "show x.toml", "check x.toml", "reference x.toml --digits 10"),
        "sweep x.toml --vary start.omega[3]=1:2:2 --workers 1",
        *("plot x.toml --what omega -o x.svg", "view x.toml -o x.html"),
    ],
)
@pytest.mark.parametrize("body", motions.RATIOS)
def test_numbers_hundreds_of_powers_of_ten_apart(body, words, capsys):
    Path("x.toml").write_text(motions.RATIO.format(*motions.RATIOS[body]))
    code = cli.main(words.split())
    err = capsys.readouterr().err
    assert code in (0, 2, 3)
    if code == 2:  # one more line may tell of the window that is drawn
        assert promise.REFUSAL.fullmatch(err.splitlines(keepends=True)[-1])
        assert err.count("\n") <= 2
    if code == 3:
        assert any(word in err for word in ("undefined", "step", "bands of digits"))


# -- the promise's own tests: each kind of fault is seen -------------------------------------------


def fail() -> None:
    raise KeyError("x")


def loop() -> None:
    while True:
        pass


def refuse() -> None:
    raise polhode.BadInput("x", "key", 1, "something")


@pytest.mark.parametrize(
    ("work", "told"), [(fail, "KeyError"), (lambda: Path("left").touch(), "files changed")]
)
def test_a_fault_is_seen(work, told):
    ((fault,), _) = promise.of_call(work)
    assert told in fault


def test_work_without_end_is_ended():
    with pytest.raises(promise.Slow), promise.limited(0.2):
        loop()


def test_a_refusal_is_no_fault():
    assert promise.of_call(refuse) == ([], True)
    assert promise.of_command(["list", "--no-such"]) == ([], 2)


# -- extreme and yet valid scenes, beside power series that share nothing with the package ---------

DIGITS = 25


def departure(rows, true, rate) -> mpf:
    """The largest error of omega over the spin, or of gamma."""
    pairs = [
        (own(x) / (number(rate) if k < 3 else 1), number(y))
        for row, right in zip(rows, true, strict=True)
        for k, (x, y) in enumerate(zip(row, right, strict=True))
    ]
    return max(abs(x - y) for x, y in pairs)


def true_rows(scene: polhode.Scene, rate) -> list[list[Fraction]]:
    """The motion by power series, in a unit of time in which the spin is about 1."""
    largest = max(scene.body.moments)
    moments = [m / largest for m in scene.body.moments]
    torque = [x / largest / rate**2 for x in scene.body.torque]
    omega, times = [w / rate for w in scene.omega], [t * rate for t in scene.times]
    digits = DIGITS + 40  # differences of moments are as small as 1e-30
    return plain_taylor.integrate(moments, torque, omega, scene.gamma, times, digits)


def judged(kind: str, count: int) -> None:
    """Right to every digit asked, and a run to as many as is said."""

    @settings(max_examples=count, **HOW)
    @given(motions.extreme(kind))
    def as_right_as_said(given: polhode.Scene) -> None:
        run = polhode.integrate(given)
        assert run.outcome.done
        scene = run.scene.at(run.times)  # those that the run was made for: rounded ones
        rate = max(abs(w) for w in scene.omega)
        true, reference = true_rows(scene, rate), polhode.reference(scene)
        worst = polhode.compare(run).worst
        with mpmath.workdps(DIGITS + 15):
            if kind != "general":
                assert reference.is_closed_form
                exact = reference.at(scene.times, DIGITS)
                assert departure(exact, true, rate) < mpf(10) ** (1 - DIGITS)
            error = departure([[mpf(float(x)) for x in row] for row in run.states], true, rate)
            fastest = max(mpmath.norm([number(x) for x in row[:3]]) for row in true)
            assert error < max(1.01 * mpf(10) ** -worst * max(1, fastest), mpf(2) ** -50)
        assert worst > 12

    as_right_as_said()


@pytest.mark.slow
@pytest.mark.parametrize("kind", motions.KINDS)
def test_an_extreme_scene_is_as_right_as_it_is_said_to_be(kind):
    judged(kind, 2)


@pytest.mark.campaign
@pytest.mark.parametrize("kind", motions.KINDS)
def test_many_extreme_scenes_are_as_right_as_they_are_said_to_be(kind):
    judged(kind, 100)
