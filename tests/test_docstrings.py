"""The front door: its names, their examples, and what comes out as a value."""

import doctest
import importlib
import inspect
import math
import pickle
import re
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import cli
from shared.tools import python

PUBLIC = [name for name in polhode.__all__ if name != "__version__"]
MODULES = ["", *sorted({getattr(polhode, name).__module__[len("polhode.") :] for name in PUBLIC})]


#: Names whose modules have examples that take long.
LONG = (
    *("prove_chaos", "prove_orbit", "prove_orbits", "prove_stability", "ProvedStability"),
    *("orbit_family", "orbit_search", "lyapunov", "frequencies", "rolling", "report"),
)
LONG_MODULES = {getattr(polhode, name).__module__ for name in LONG}


@pytest.mark.parametrize(
    "module",
    [pytest.param(m, marks=[pytest.mark.slow] * (f"polhode.{m}" in LONG_MODULES)) for m in MODULES],
)
def test_every_example_runs_and_prints_what_it_says(module):
    with mpmath.workprec(53):  # that of a caller who leaves it alone
        outcome = doctest.testmod(importlib.import_module(f"polhode.{module}".rstrip(".")))
    assert outcome.attempted > 0
    assert outcome.failed == 0


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_an_example_and_its_members_say_what_they_are(name):
    thing = getattr(polhode, name)
    assert ">>> " in (inspect.getdoc(thing) or "")
    for key, member in vars(thing).items() if inspect.isclass(thing) else ():
        if not key.startswith("_") and (callable(member) or isinstance(member, property)):
            assert (inspect.getdoc(member) or "").strip(), key


@pytest.mark.parametrize("name", ["orbit", "orbit_family", "prove_orbit", "prove_stability"])
def test_another_argument_is_refused_with_the_nearest(name):
    more = ("h", 3) if name == "orbit_family" else ()
    with pytest.raises(polhode.BadInput, match=r"perod = 6: expected an argument: .*period"):
        getattr(polhode, name)("grioli/precession", *more, perod=6)


def test_tab_completion_shows_the_api_and_nothing_else():
    code = (
        "import polhode; polhode.load('euler/sphere'); "
        "assert dir(polhode) == sorted(polhode.__all__); print(polhode.__version__)"
    )
    assert python("-c", code, check=True).stdout.strip() == polhode.__version__
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        getattr(polhode, "nothing")  # noqa: B009


def test_other_states_are_another_trajectory():
    run = polhode.integrate("lagrange/nutation", at=[1, 2])
    moved = np.array(run.states)
    moved[1, 3] = np.nextafter(moved[1, 3], 2)
    assert replace(run, states=moved) != run
    assert replace(run, states=np.array(run.states)) == run
    with pytest.raises(TypeError, match="unhashable"):
        hash(run)


@pytest.mark.parametrize(
    ("first", "second", "equal"),
    [
        (np.array([1.0, math.nan]), np.array([1.0, math.nan]), True),
        (np.array([1.0]), np.array([1.0], dtype=np.longdouble), False),
        (np.array([1.0]), np.array([[1.0]]), False),
        (np.array([Fraction(1), None]), np.array([Fraction(1), None]), True),
        ([1, [2]], [1, [3]], False),
        ([1], (1,), False),
        ({"a": [1]}, {"b": [1]}, False),
        (math.nan, math.nan, True),
        (math.nan, 1.0, False),
    ],
)
def test_equality_of_results_looks_into_arrays_lists_and_mappings(first, second, equal):
    run = polhode.integrate("euler/sphere", at=[0])
    first_run, second_run = (replace(run, states=x) for x in (first, second))
    assert (first_run == second_run) is (second_run == first_run) is equal


def test_bad_input_crosses_to_other_processes():
    fault = polhode.BadInput("x.toml", "body.weight", "one", "a number")
    again = pickle.loads(pickle.dumps(fault))
    assert str(again) == str(fault) == "x.toml: body.weight = one: expected a number"
    assert (again.source, again.key) == ("x.toml", "body.weight")


def test_a_reference_that_was_used_keeps_its_digits_when_pickled():
    """mpmath reads an mpf back at the precision in force: constants kept so would be doubles."""
    exact = polhode.reference("kovalevskaya/generic")
    rows = exact.at([1], 50)
    assert pickle.loads(pickle.dumps(exact)).at([1], 50) == rows


# -- the documentation of the public names, as the signatures are ----------------------------------

ALL_NAMES = [name for name in polhode.__all__ if not name.startswith("_")]
FUNCTIONS = [name for name in ALL_NAMES if inspect.isroutine(getattr(polhode, name))]


def sections(text: str) -> dict[str, str]:
    _, *parts = re.split(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", text, flags=re.M)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def entries(section: str) -> list[str]:
    heads = [line.partition(" : ")[0] for line in section.splitlines() if re.match(r"\S", line)]
    return [name.strip() for head in heads for name in head.split(",")]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_of_a_public_function_is_told_once_and_nothing_else(name):
    function = getattr(polhode, name)
    told_sections = sections(inspect.getdoc(function))
    signature = inspect.signature(function)
    returns = ["Returns"] if signature.return_annotation != "None" else []
    takes = ["Parameters"] if signature.parameters else []
    assert {*takes, *returns, "Raises", "Examples"} <= set(told_sections)
    assert ("Returns" in told_sections) == bool(returns)
    parameters = [
        {p.VAR_KEYWORD: "**", p.VAR_POSITIONAL: "*"}.get(p.kind, "") + p.name
        for p in signature.parameters.values()
    ]
    assert sorted(entries(told_sections.get("Parameters", ""))) == sorted(parameters)
    for kind in (*returns, "Raises"):
        assert entries(told_sections[kind])
    assert told_sections["Examples"].startswith(">>> ")
    for section in (*takes, *returns, "Raises"):
        for entry in re.split(r"\n(?=\S)", told_sections[section].strip()):
            assert "\n    " in entry, f"{name}: nothing is said of {entry}"


def test_the_guide_lists_every_public_name(capsys):
    assert cli.main(["guide", "python"]) == 0
    listed = re.findall(r"^\| `polhode\.(\w+)", capsys.readouterr().out, re.M)
    assert listed == sorted(ALL_NAMES, key=lambda name: (name[0].isupper(), name))
