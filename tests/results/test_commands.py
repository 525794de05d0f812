"""Commands and Python write the same bytes, of every kind of result and every ending."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

import polhode
from polhode.cli import main
from polhode.results.writer import ENDINGS

TOP = "lagrange/nutation"
GENERAL = "general/asymmetric-regular"
VARY = {"start.omega[3]": "2:4:3"}

#: Commands without -o, and the same in Python.
SAME: dict[str, Callable[[], polhode.Trajectory]] = {
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
}
#: Those that draw their results.
DRAWN = [
    *(
        f"{command} -o x.svg"
        for command in SAME
        if not command.startswith(("orbits", "prove orbits"))
    ),
    "prove chaos general/asymmetric-chaotic -o x.svg",
    f"compare run.csv {TOP} -o x.svg",
]
CERTIFICATES = ("certify", "prove orbit grioli")


@pytest.mark.sample(6)
@pytest.mark.parametrize("command", SAME)
def test_a_command_writes_what_save_writes_and_prints_what_to_json_gives(
    command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    certified = command.startswith(CERTIFICATES)
    endings = [x for x in ENDINGS if not (certified and x == ".json")]
    if find_spec("pyarrow") is None:
        endings.remove(".parquet")
    words = shlex.split(command)
    places = [word for ending in endings for word in ("-o", f"x{ending}")]
    for _ in range(2):  # its own kind is replaced
        assert main([*words, *places]) == 0
    assert capsys.readouterr().out == ""
    assert main([*words, "--json"]) == 0
    printed = capsys.readouterr().out
    found = SAME[command]()
    assert printed == found.to_json()
    for ending in endings:
        found.save(f"y{ending}")
        for end in (ending, ".csv.json") if ending == ".csv" else (ending,):
            assert Path(f"x{end}").read_bytes() == Path(f"y{end}").read_bytes()
        again = polhode.load_result(f"x{ending}")
        assert again.to_json() == printed


@pytest.mark.sample(8)
@pytest.mark.parametrize("command", DRAWN)
def test_a_command_draws_its_result(command, tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    polhode.integrate(TOP, at=[0, 1, 2]).save("run.csv")
    assert main(shlex.split(command)) == 0
    assert Path("x.svg").read_text().startswith("<?xml")
    assert capsys.readouterr().out == ""
