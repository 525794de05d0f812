"""The house: linters, types, the layer table, and what a verb may import."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]


@pytest.mark.parametrize(
    "command",
    [
        ["ruff", "check", "src", "tests"],
        ["ruff", "format", "--check", "src", "tests"],
        ["mypy"],
        ["lint-imports"],
    ],
    ids=["ruff", "format", "mypy", "layers"],
)
def test_linters_find_nothing(command):
    tool = Path(sys.executable).parent / command[0]
    done = subprocess.run([tool, *command[1:]], cwd=TOP, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_contributing_prints_the_enforced_layers():
    """Every room of the layer contract stands in CONTRIBUTING's table, on the same floor."""
    with (TOP / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    enforced = [set(re.split(r"[ :|]+", layer)) for layer in contracts[0]["layers"]]
    rows = re.findall(r"^\| (\d+) \| (.*?) \|", (TOP / "CONTRIBUTING.md").read_text(), re.M)
    assert len(rows) == len(enforced)
    for (_, rooms), layer in zip(rows, enforced, strict=True):
        assert set(re.findall(r"`(\w+)/?`", rooms)) == layer


def test_nobody_computes_at_a_precision_that_others_share():
    """Mpmath's context and flint's are imported where they are made private, and nowhere else."""
    private = {"numbers/private.py", "numbers/balls.py", "common/values.py"}
    shared = re.compile(r"^ *(import mpmath|from mpmath import (?!libmp)|from flint.*\bctx)", re.M)
    for path in (TOP / "src/polhode").rglob("*.py"):
        name = path.relative_to(TOP / "src/polhode").as_posix()
        if name not in private and not name.startswith("peers/"):
            assert not shared.search(path.read_text()), name


def test_tracked_text_names_no_machine():
    """No absolute path of a machine in the sources, cases, reports or documents."""
    pattern = re.compile(r"(?<![\w.])/(home|root|work|tmp|Users)/")
    for folder in ("src", "cases", "reports", "."):
        for path in (TOP / folder).glob("**/*" if folder != "." else "*"):
            if path.suffix in (".py", ".toml", ".md", ".json", ".cff"):
                assert not pattern.search(path.read_text()), path


def imported_by(arguments: list[str]) -> set[str]:
    code = (
        "import sys; from polhode.cli import main; "
        f"code = main({arguments!r}); assert code == 0, code; "
        "print(*sorted(sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stderr.splitlines()[-1].split())


def test_a_verb_imports_nothing_heavy_that_it_does_not_need():
    run = imported_by(["run", "euler/sphere", "--json"])
    assert "heyoka" in run
    assert not {"matplotlib", "scipy", "sympy"} & run
    for arguments in (["list", "--json"], ["reference", "euler/sphere", "--json"]):
        assert "heyoka" not in imported_by(arguments)


def test_the_closed_forms_run_where_heyoka_is_missing():
    code = (
        "import sys; sys.modules['heyoka'] = None; import polhode; "
        "print(polhode.reference('euler/separatrix').at([1], 20)[0][0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
