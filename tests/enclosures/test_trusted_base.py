"""What is called trusted: all of it, and nothing that a proof does not rest on."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import grimp

import polhode
from polhode.enclosures.statement import BESIDE, TRUSTED, trusted_lines

TOP = Path(polhode.__file__).parent


@cache
def graph() -> grimp.ImportGraph:
    return grimp.build_graph("polhode", exclude_type_checking_imports=True, cache_dir=None)


def imported(name: str) -> set[str]:
    """The files that a file imports, by their places in the package, as it is named itself."""
    module = f"polhode.{name.replace('/', '.')}".removesuffix(".__init__")
    names = {
        x.removeprefix("polhode.").replace(".", "/")
        for x in graph().find_modules_directly_imported_by(module)
    }
    return {f"{x}/__init__" if (TOP / x).is_dir() else x for x in names}


def is_beside(name: str) -> bool:
    return any(name == part or name.startswith(f"{part}/") for part in BESIDE)


def test_a_trusted_file_imports_what_is_trusted_or_said_to_be_beside_and_a_statement_counts_them():
    names = {x for name in TRUSTED for x in imported(name)}
    assert {x for x in names - {*TRUSTED} if not is_beside(x)} == set()
    for part, why in BESIDE.items():
        assert any(x == part or x.startswith(f"{part}/") for x in names), part
        assert why
    assert [name for name in TRUSTED if is_beside(name)] == []
    # the room of proofs is trusted but for what approximates
    files = {
        p.relative_to(TOP).with_suffix("").as_posix() for p in (TOP / "enclosures").rglob("*.py")
    }
    rest = files - set(TRUSTED)
    assert rest == {"enclosures/approximation"}
    sentence = polhode.certify("euler/sphere", at=[1]).statement[4]
    assert f"{trusted_lines()} lines of polhode in {len(TRUSTED)} files" in sentence
    assert 8000 < trusted_lines() < 11_000


def test_what_approximates_makes_no_value_that_a_proof_believes():
    """Bounds, Step and State come out of the trusted files alone."""
    tree = ast.parse((TOP / "enclosures/approximation.py").read_text())
    calls = {ast.unparse(n.func).split(".")[-1] for n in ast.walk(tree) if isinstance(n, ast.Call)}
    assert calls
    assert not calls & {"Bounds", "Step", "State", "Proof", "Enclosure", "TurnBounds", "Crossing"}
