"""Whatever is given, the promise is kept: cases that hypothesis makes, see :mod:`fuzz.promise`.

Many more of each class: ``tests/campaigns/hostile_input.py``.
"""

from pathlib import Path

import pytest

import polhode
from fuzz import cases, promise, trials
from polhode import cli
from polhode.output import description
from shared.motions import heavy_file

#: How many cases of each class are tried.
COUNTS = {"scene": 25, "call": 40, "toml": 12, "table": 6, "command": 12}
COUNTS |= {"result": 12, "body": 8, "event": 3, "proof": 2}
SWEEP = "sweep x.toml --vary start.omega[3]=1:2:2 --workers 1"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cases.prepared(tmp_path)
    monkeypatch.setattr(description, "SECONDS", 0.05)  # that show looks for frequencies


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_the_promise_is_kept(kind):
    ends = trials.keep_many(kind, COUNTS[kind])
    if kind == "scene":  # what is refused is made, and what is not
        assert len(ends) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*cases.CALLS} - {"rolling"}))  # which is given no run
def test_a_call_that_is_not_spoiled_is_not_refused(name):
    function, arguments, named = cases.CALLS[name]
    right = {key: value for key, value in named.items() if value is not None}
    assert trials.keep(cases.Case(name, {}, lambda: function(*arguments, **right))) is False


@pytest.mark.parametrize("kind", ["scene", "toml"])
def test_the_promise_is_kept_by_some_texts(kind):
    trials.keep_many(kind, 4)


@pytest.mark.filterwarnings("ignore")  # those of matplotlib's own, of numbers like these
@pytest.mark.parametrize(
    ("words", "body"),
    [
        ("run x.toml", "a moment near zero"),
        ("show x.toml", "beyond doubles"),
        ("reference x.toml --digits 10", "small ones"),
        pytest.param("run x.toml", "beyond doubles", marks=pytest.mark.slow),
        pytest.param("check x.toml", "a heavy one", marks=pytest.mark.slow),
        pytest.param(SWEEP, "another one", marks=pytest.mark.slow),
        pytest.param("plot x.toml --what omega -o x.svg", "a heavy one", marks=pytest.mark.slow),
        pytest.param("view x.toml -o x.html", "small ones", marks=pytest.mark.slow),
    ],
)
def test_numbers_hundreds_of_powers_of_ten_apart(words, body, capsys):
    moments, centre, weight = cases.RATIOS[body]
    Path("x.toml").write_text(heavy_file("10", "3", 5, weight, moments, centre))
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
    ("work", "words"), [(fail, "KeyError"), (lambda: Path("left").touch(), "files changed")]
)
def test_a_fault_is_seen(work, words):
    ((fault,), _) = promise.of_call(work)
    assert words in fault


def test_work_without_end_is_ended():
    with pytest.raises(promise.Slow), promise.limited(0.2):
        loop()


def test_a_refusal_is_no_fault():
    assert promise.of_call(refuse) == ([], True)
    assert promise.of_command(["list", "--no-such"]) == ([], 2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", cases.KINDS)
def test_an_extreme_scene_is_as_right_as_it_is_said_to_be(kind):
    trials.judge_extreme_scenes(kind, 2)
