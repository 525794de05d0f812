"""Commands and Python write the same bytes, of every kind of result and every ending."""

import shlex
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from invented import ENDINGS

import polhode
from polhode.cli import main
from shared.results import (
    EXAMPLES,
    GENERAL,
    TOP,
    WITH_RESULT,
    order_of,
    prepare,
    result_of_kind,
    verb_of,
    without_files,
)
from shared.tools import even_times, tiers

VARY = {"start.omega[3]": "2:4:3"}
#: What the example of each verb gives, by its kind of result, or in Python.
KIND_OF = {
    "list": "Cases",
    "show": "Description",
    "reference": "ReferenceTable",
    "certify": "Enclosure",
    "check": "CheckReport",
    "sweep": "Ensemble",
    "levels": "Levels",
    "section": "Section",
    "map": "ChaosMap",
    "orbit": "Orbit",
    "orbits": "OrbitSearch",
    "family": "OrbitFamily",
    "prove orbit": "ProvedOrbit",
    "prove orbits": "ProvedOrbits",
    "prove stability": "ProvedStability",
    "frequencies": "Frequencies",
    "about": "About",
}
SAME: dict[str, Callable[[], Any]] = {
    **{verb: partial(result_of_kind, kind) for verb, kind in KIND_OF.items()},
    "run": lambda: polhode.integrate(polhode.load("top.toml").at(even_times(Fraction(1, 2), 51))),
    "compare": lambda: replace(
        polhode.compare(Path("top.csv"), "top.toml", details=True),
        motion=polhode.lyapunov("top.toml", max_steps=100_000),
    ),
    "order": lambda: order_of(["coarse.csv", "fine.csv"], ["0.02", "0.01"]),
    "verify": lambda: polhode.verify("state.json"),
}
#: Whose answers have times of a clock.
MEASURED = {"report"}
#: Other commands, and the same in Python.
MORE: dict[str, Callable[[], Any]] = {
    f"run {TOP} --at 0,1/3,pi": lambda: polhode.integrate(TOP, at=["0", "1/3", "pi"]),
    f"run {TOP} --number quad --at 1": lambda: polhode.integrate(TOP, "quad", at=[1]),
    f"run {TOP} --digits 20 --at 1 --no-prove": lambda: polhode.integrate(
        TOP, digits=20, at=[1], prove=False
    ),
    f"sweep {TOP} --vary 'start.omega[3]=2:4:3' --keep final --at 1": lambda: polhode.reduce_many(
        TOP, VARY, ["final"], at=[1]
    ),
    f"orbits {GENERAL} --grid 4x4 --crossings 1 --pick 1 --digits 20": lambda: polhode.orbit_search(
        GENERAL, (4, 4), crossings=1
    ).orbit(0, 20),
}
COMMANDS = {without_files(EXAMPLES[verb]): same for verb, same in SAME.items()} | MORE
DRAWN = [*(f"{x} -o x.svg" for x in COMMANDS if verb_of(x).figure_options is not None)]
QUICK = ["run top.toml --samples 51", "run lagrange/nutation --number quad --at 1"]
#: Which are carried out once.
DEAR = ("prove", "family", "section", "check", "compare", "map", "order", "orbit", "frequencies")
CERTIFICATES = ("certify", "prove orbit grioli", "prove stability")


@pytest.mark.parametrize("command", tiers(QUICK, [x for x in COMMANDS if x not in QUICK]))
def test_a_command_writes_what_save_writes_and_prints_what_to_json_gives(
    command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    prepare(command)
    capsys.readouterr()  # what that printed
    certified = command.startswith(CERTIFICATES)
    endings = [x for x in ENDINGS if not (certified and x == ".json")]
    if find_spec("pyarrow") is None:
        endings.remove(".parquet")
    words = shlex.split(command)
    places = [word for ending in endings for word in ("-o", f"x{ending}")]
    files = ", ".join(f"x{ending}" for ending in endings)
    written = f"written: {files.replace('x.csv', 'x.csv, x.csv.json')}"
    if not command.startswith(DEAR):
        assert main([*words, *places]) == 0
        out, err = capsys.readouterr()
        prints_rows = verb_of(command).prints_rows and "--pick" not in words  # that is an orbit
        assert (out == "") == prints_rows
        assert err.splitlines()[-1] == written
    assert main([*words, *places, "--json"]) == 0  # its own kind is replaced
    printed, err = capsys.readouterr()
    assert err.splitlines()[-1] == written
    result = COMMANDS[command]()
    assert printed == result.to_json()
    for ending in endings:
        result.save(f"y{ending}")
        for end in (ending, ".csv.json") if ending == ".csv" else (ending,):
            assert Path(f"x{end}").read_bytes() == Path(f"y{end}").read_bytes()
        again = polhode.load_result(f"x{ending}")
        assert again.to_json() == printed


@pytest.mark.slow
@pytest.mark.parametrize("command", [DRAWN[0], DRAWN[6], DRAWN[-1]])
def test_a_command_draws_its_result_and_prints_what_the_figure_has_not(
    command, tmp_path, monkeypatch, capsys
):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    prepare(command)
    capsys.readouterr()  # what that printed
    words = shlex.split(command)
    assert main(words) == 0
    assert Path("x.svg").read_text().startswith("<?xml")
    out, err = capsys.readouterr()
    assert err.splitlines()[-1] == "written: x.svg"
    assert main(words[:-2]) == 0
    assert capsys.readouterr().out == out != ""


def test_every_verb_with_a_result_is_a_command_here():
    """But the one that takes minutes, whose answer the next test prints."""
    assert {*SAME} == WITH_RESULT - {"prove chaos"} - MEASURED


@pytest.mark.parametrize("verb", tiers([x for x in EXAMPLES if x not in WITH_RESULT], [*MEASURED]))
def test_the_example_of_a_verb_that_writes_pages_runs(verb, tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    prepare(EXAMPLES[verb])
    capsys.readouterr()
    assert main(shlex.split(EXAMPLES[verb])) == 0
    out, _ = capsys.readouterr()
    _, _, place = EXAMPLES[verb].partition(" -o ")
    assert out
    assert not place or Path(place).exists()


@pytest.mark.parametrize("verb", EXAMPLES)
def test_help_prints_the_example(verb, capsys):
    with pytest.raises(SystemExit):
        main([*verb.split(), "--help"])
    assert capsys.readouterr().out.endswith(f"example:\n  polhode {EXAMPLES[verb]}\n")


def test_a_proof_of_minutes_is_told_although_it_is_saved(tmp_path, monkeypatch, capsys):
    """Entropy and margins were lost."""
    proved = result_of_kind("ProvedChaos")
    monkeypatch.setattr("polhode.proofs.proved_chaos.prove_chaos", lambda **_: proved)
    monkeypatch.chdir(tmp_path)
    for places in ([], ["-o", "x.json"], ["-o", "x.csv"]):
        assert main(["prove", "chaos", "grioli/precession", *places]) == 0
        out, err = capsys.readouterr()
        assert out == f"{proved}\n"
        assert "entropy     at least 1.0e-01" in out
        assert places == [] or "x." in err.splitlines()[-1]
    assert main(["prove", "chaos", "grioli/precession", "-o", "x.json", "--json"]) == 0
    assert capsys.readouterr().out == proved.to_json()


@pytest.mark.parametrize(("flags", "code"), [([], 0), (["--at-least", "99"], 3)])
def test_a_verdict_goes_to_stderr_where_stdout_is_the_files(
    flags, code, tmp_path, monkeypatch, capsys
):
    """And the exit code is the verdict's, whatever is written."""
    monkeypatch.chdir(tmp_path)
    command = f"compare fine.csv {TOP}"
    prepare(command)
    words = [*command.split(), *flags]
    assert main([*words, "-o", "x.npz"]) == code
    answer = capsys.readouterr().out
    assert "correct digits" in answer
    assert main([*words, "-o", "-"]) == code
    out, err = capsys.readouterr()
    assert out.startswith("t,correct_digits")
    assert err.startswith(answer)
