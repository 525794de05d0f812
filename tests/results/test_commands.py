"""Commands and Python write the same bytes, of every kind of result and every ending."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import polhode
from polhode.checks.check_report import check_cases
from polhode.cli import main
from polhode.judging.convergence_order import order_between
from polhode.output.about import about
from polhode.output.cases import cases
from polhode.output.description import describe
from polhode.proofs import prove_chaos
from polhode.proofs.proved_chaos import ProvedChaos
from polhode.results.writer import ENDINGS
from polhode.verbs.catalogue import VERBS, Verb

TOP = "lagrange/nutation"
GENERAL = "general/asymmetric-regular"
VARY = {"start.omega[3]": "2:4:3"}

#: Commands without -o, and the same in Python.
SAME: dict[str, Callable[[], Any]] = {
    "list --tag euler": lambda: cases("euler"),
    f"show {TOP}": lambda: describe(TOP),
    "about --cite": lambda: about(cite=True),
    "check euler/rest --number double": lambda: check_cases(["euler/rest"], number=["double"]),
    f"compare run.csv {TOP}": lambda: polhode.compare(Path("run.csv"), TOP),
    f"order run.csv fine.csv {TOP} --steps 2,1": lambda: order_between(
        [polhode.compare(Path(name), TOP) for name in ("run.csv", "fine.csv")], ["2", "1"]
    ),
    "verify cert.json": lambda: polhode.verify("cert.json"),
    f"run {TOP} --at 0,1/3,pi": lambda: polhode.integrate(TOP, at=["0", "1/3", "pi"]),
    f"run {TOP} --number quad --at 1": lambda: polhode.integrate(TOP, "quad", at=[1]),
    f"run {TOP} --digits 20 --at 1 --no-prove": lambda: polhode.integrate(
        TOP, digits=20, at=[1], prove=False
    ),
    f"reference {TOP} --at 1/3 --digits 40": lambda: polhode.reference_table(
        TOP, at=["1/3"], digits=40
    ),
    f"certify {GENERAL} --at 1 --digits 20": lambda: polhode.certify(
        polhode.load(GENERAL).at([1]), digits=20
    ),
    f"sweep {TOP} --vary 'start.omega[3]=2:4:3' --at 0,1": lambda: polhode.integrate_many(
        TOP, VARY, at=[0, 1]
    ),
    f"sweep {TOP} --vary 'start.omega[3]=2:4:3' --keep final --at 1": lambda: polhode.reduce_many(
        TOP, VARY, ["final"], at=[1]
    ),
    f"levels {GENERAL}": lambda: polhode.levels(GENERAL),
    f"section {GENERAL} --grid 2x2 --crossings 3": lambda: polhode.section(
        GENERAL, grid=(2, 2), crossings=3
    ),
    f"map {GENERAL} --grid 2x2 --end 20": lambda: polhode.chaos_map(GENERAL, (2, 2), end=20),
    "orbit grioli/precession --digits 20": lambda: polhode.orbit("grioli/precession", 20),
    f"orbits {GENERAL} --grid 4x4 --crossings 1": lambda: polhode.orbit_search(
        GENERAL, (4, 4), crossings=1
    ),
    "family grioli/precession --by h --to 0.84": lambda: polhode.orbit_family(
        "grioli/precession", "h", "0.84"
    ),
    f"frequencies {TOP} --of gamma3 --end 50": lambda: polhode.frequencies(TOP, ["gamma3"], 50),
    "prove orbit grioli/precession": lambda: polhode.prove_orbit("grioli/precession"),
    f"prove orbits {GENERAL} --grid 4x4 --crossings 1": lambda: polhode.prove_orbits(
        GENERAL, (4, 4), crossings=1
    ),
    f"prove stability {GENERAL}": lambda: polhode.prove_stability(GENERAL),
}
#: Those that draw their results.
WITHOUT_FIGURE = ("list", "show", "about", "check", "order", "orbits", "verify", "prove orbits")
DRAWN = [
    *(f"{command} -o x.svg" for command in SAME if not command.startswith(WITHOUT_FIGURE)),
    pytest.param("prove chaos general/asymmetric-chaotic -o x.svg", marks=pytest.mark.campaign),
]
CERTIFICATES = ("certify", "prove orbit grioli", "prove stability")


def verb_of(command: str) -> Verb:
    """The row of a command's verb, of two words if there is one."""
    first, second = command.split()[:2]
    return VERBS.get(f"{first} {second}") or VERBS[first]


def files_read(command: str) -> None:
    """Files that a command reads: other programs' tables with errors, a certificate."""
    if command.startswith(("compare", "order")):
        run = polhode.integrate(TOP, at=[1, 2, 3])
        for name, digits in (("run.csv", 3), ("fine.csv", 5)):
            cells = [[repr(float(x) + 10.0**-digits) for x in row] for row in run.states]
            rows = [f"{t},{','.join(row)}" for t, row in zip("123", cells, strict=True)]
            Path(name).write_text("\n".join(["t,p,q,r,gamma1,gamma2,gamma3", *rows, ""]))
    if command.startswith("verify"):
        polhode.certify("euler/largest-axis", at=[1], digits=20).save("cert.json")


@pytest.mark.sample(5, first=2, slow=8)
@pytest.mark.parametrize("command", SAME)
def test_a_command_writes_what_save_writes_and_prints_what_to_json_gives(
    command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    files_read(command)
    certified = command.startswith(CERTIFICATES)
    endings = [x for x in ENDINGS if not (certified and x == ".json")]
    if find_spec("pyarrow") is None:
        endings.remove(".parquet")
    words = shlex.split(command)
    places = [word for ending in endings for word in ("-o", f"x{ending}")]
    assert main(words) == 0
    answer = capsys.readouterr().out
    assert main([*words, *places]) == 0
    out, err = capsys.readouterr()
    assert out == ("" if verb_of(command).prints_rows else answer)
    files = ", ".join(f"x{ending}" for ending in endings)
    assert err.splitlines()[-1] == f"written: {files.replace('x.csv', 'x.csv, x.csv.json')}"
    assert main([*words, *places, "--json"]) == 0  # its own kind is replaced
    printed = capsys.readouterr().out
    found = SAME[command]()
    assert printed == found.to_json()
    for ending in endings:
        found.save(f"y{ending}")
        for end in (ending, ".csv.json") if ending == ".csv" else (ending,):
            assert Path(f"x{end}").read_bytes() == Path(f"y{end}").read_bytes()
        again = polhode.load_result(f"x{ending}")
        assert again.to_json() == printed


@pytest.mark.sample(0, slow=3)
@pytest.mark.parametrize("command", DRAWN)
def test_a_command_draws_its_result_and_prints_what_the_figure_has_not(
    command, tmp_path, monkeypatch, capsys
):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    files_read(command)
    words = shlex.split(command)
    assert main(words) == 0
    assert Path("x.svg").read_text().startswith("<?xml")
    out, err = capsys.readouterr()
    assert err.splitlines()[-1] == "written: x.svg"
    assert main(words[:-2]) == 0
    assert capsys.readouterr().out == out != ""


def test_every_verb_is_a_command_here():
    """But the one that takes minutes, whose answer the next test prints."""
    assert {verb_of(command).name for command in SAME} == {*VERBS} - {"prove chaos"}


def test_a_proof_of_minutes_is_told_although_it_is_saved(tmp_path, monkeypatch, capsys):
    """Entropy and margins were lost."""
    orbit = polhode.prove_orbit("grioli/precession")
    numbers = {"short": 3.0, "long": 4.0, "entropy": 0.1, "tries": 1, "seconds": 1.0}
    numbers |= {"coverings": 20, "sets": 19, "stretch": 1.5, "height": 0.5, "cone": 0.25}
    numbers |= {
        "scene": orbit.scene,
        "orbit": orbit,
        "certificate": orbit.certificate,
        "size": 1e-3,
    }
    proved = ProvedChaos(h=orbit.h, f=orbit.f, **numbers, guess=None, images=())
    monkeypatch.setattr(prove_chaos, "prove_chaos", lambda **_: proved)
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
    command = f"compare run.csv {TOP}"
    files_read(command)
    words = [*command.split(), *flags]
    assert main(words) == code
    answer = capsys.readouterr().out
    assert "correct digits" in answer
    assert main([*words, "-o", "-"]) == code
    out, err = capsys.readouterr()
    assert out.startswith("t,correct_digits")
    assert err.startswith(answer)
    assert main([*words, "-o", "x.npz"]) == code
    assert capsys.readouterr().out == answer
