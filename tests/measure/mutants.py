"""Would a test notice?  Small random changes of the code, each run against the tests of its file.

    python tests/measure/mutants.py times TIMES.json [TESTS...]
    python tests/measure/mutants.py run TIMES.json RESULT.json [--count N] [--seed N]
                                     [--package P ...]
    python tests/measure/mutants.py again TIMES.json RESULT.json
    python tests/measure/mutants.py show RESULT.json

``times`` runs the fast tests (or the TESTS named) once and writes down how long each takes.
``run`` draws mutants, all places of all rooms equally likely, and runs on each one the tests of its
package: first those of files named like the changed one or its folder, then the others, the
quickest first, until a test fails or about ``BUDGET`` seconds of tests have passed.  Each mutant
lives in a copy of the project, never in the project itself.  It is killed by a test that fails, or
that takes ``PATIENCE`` times its processor time.  The result is written after every mutant, and a
run that was interrupted goes on where it was.  ``again`` runs the survivors once more, on today's
tests and with ten times the budget.

Nothing here passes or fails by itself: survivors are for a reader, who writes a test, or names the
reason why no test can tell the mutant from the code.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, NoReturn
from xml.etree import ElementTree

import flint  # noqa: F401  what every child would import by itself
import heyoka  # noqa: F401
import hypothesis  # noqa: F401
import mpmath  # noqa: F401
import numpy  # noqa: F401
import pytest

TOP = Path(__file__).parents[2]
SOURCE = Path("src/polhode")
#: Where the tests of each room lie.
ROOMS = {
    "numbers": ("numbers", "scenes", "judging", "equations"),
    "equations": ("equations", "runs", "taylor"),
    "taylor": ("taylor", "runs", "judging"),
    "judging": ("judging", "checks", "verbs", "equations", "output"),
    "closed_forms": ("closed_forms", "checks"),
    "refined": ("refined", "runs"),
    "enclosures": ("enclosures", "judging"),
    "dynamics": ("dynamics", "verbs"),
    "runs": ("runs", "judging"),
}
FIRST = 12.0  # seconds of tests of the first round
BUDGET = 60.0  # and of both
PATIENCE = 5  # a test that takes so much longer than before fails
GRACE = 60  # seconds of processor time for imports, and for compiling what changed
OTHER = {
    **{ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And},
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult},
    **{ast.FloorDiv: ast.Div, ast.Mod: ast.FloorDiv, ast.Pow: ast.Mult},
    **{ast.LShift: ast.RShift, ast.RShift: ast.LShift},
}
OPPOSITE = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt}


class Mutant(NamedTuple):
    """One change: the text between two offsets of a file (in bytes) becomes another."""

    file: str
    line: int
    start: int
    end: int
    kind: str
    before: str
    after: str


def mutants(file: Path) -> list[Mutant]:
    """All changes of one file."""
    text = (TOP / file).read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node, kind, new in changes(ast.parse(text)):
        begin = starts[node.lineno - 1] + node.col_offset
        end = starts[node.end_lineno - 1] + node.end_col_offset
        after = ast.unparse(new)
        if isinstance(new, ast.expr) and not isinstance(new, ast.Constant | ast.Call):
            after = f"({after})"
        before = text[begin:end].decode()
        if before != after:
            found.append(Mutant(str(file), node.lineno, begin, end, kind, before, after))
    return found


def changes(tree: ast.AST) -> Iterator[tuple[Any, str, ast.AST]]:
    """Every node that may change, the kind of change, and what stands there instead."""
    for node in code(tree):
        match node:
            case ast.Constant(value=bool(x)):
                yield node, "constant", ast.Constant(not x)
            case ast.Constant(value=int(x)):
                yield node, "number", ast.Constant(x + 1)
                if x > 0:
                    yield node, "number", ast.Constant(x - 1)
            case ast.Constant(value=float(x)):
                yield node, "number", ast.Constant(x * 1.01 or 1.0)
            case ast.UnaryOp(op=ast.USub() | ast.Not()):
                yield node, "sign or not dropped", node.operand
            case ast.BinOp() | ast.BoolOp() if type(node.op) in OTHER:
                yield node, "operator", with_(node, op=OTHER[type(node.op)]())
            case ast.Compare(ops=[op]):
                yield node, "comparison", with_(node, ops=[OTHER[type(op)]()])
                if type(op) in OPPOSITE:
                    yield node, "comparison", with_(node, ops=[OPPOSITE[type(op)]()])
            case ast.AugAssign() if type(node.op) in OTHER:
                yield node, "operator", with_(node, op=OTHER[type(node.op)]())
                yield node, "statement dropped", ast.Pass()
            case ast.Expr(value=ast.Call()) | ast.Raise() | ast.Continue() | ast.Break():
                yield node, "statement dropped", ast.Pass()
        if isinstance(node, ast.Call) and ast.unparse(node.func) != "isinstance":
            for k in range(len(node.args) - 1):
                one, two = node.args[k : k + 2]
                if not isinstance(one, ast.Starred) and not isinstance(two, ast.Starred):
                    args = [*node.args[:k], two, one, *node.args[k + 2 :]]
                    yield node, "arguments exchanged", with_(node, args=args)
        if isinstance(node, ast.If | ast.While | ast.IfExp):
            yield node.test, "condition negated", ast.UnaryOp(ast.Not(), node.test)


def code(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes that run: no annotation, no printed text, no ``assert`` for the type checker."""
    yield node
    for name, field in ast.iter_fields(node):
        if name in ("annotation", "returns"):
            continue
        for child in field if isinstance(field, list) else [field]:
            if isinstance(child, ast.AST) and not isinstance(child, ast.JoinedStr | ast.Assert):
                yield from code(child)


def with_(node: ast.AST, **fields: Any) -> ast.AST:
    """A copy of the node with other fields."""
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other


def mutated(text: bytes, mutant: Mutant) -> bytes:
    return text[: mutant.start] + mutant.after.encode() + text[mutant.end :]


def compiles(text: bytes) -> bool:
    try:
        compile(text, "mutant", "exec")
    except (SyntaxError, ValueError):
        return False
    return True


def drawn(count: int, seed: int, packages: Iterable[str]) -> list[Mutant]:
    """Mutants drawn without repetition; no two of the same kind at the same place."""
    every = []
    for room in packages:
        for path in sorted((TOP / SOURCE / room).rglob("*.py")):
            every += mutants(path.relative_to(TOP))
    random.Random(seed).shuffle(every)
    found: dict[Any, Mutant] = {}
    for mutant in every:
        place = (mutant.file, mutant.start, mutant.end, mutant.kind)
        if place not in found and compiles(mutated((TOP / mutant.file).read_bytes(), mutant)):
            found[place] = mutant
            if len(found) == count:
                break
    return list(found.values())


def take_times(target: Path, tests: list[str]) -> None:
    """Run the tests once; how long each takes, by its name, and none that fails."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        subprocess.run([sys.executable, "-m", "pytest", f"--junitxml={report}", *tests], cwd=TOP)
        found = {}
        for case in ElementTree.parse(report).iter("testcase"):
            if all(child.tag not in ("failure", "error", "skipped") for child in case):
                file = case.get("classname", "").replace(".", "/") + ".py"
                found[f"{file}::{case.get('name')}"] = float(case.get("time", 0))
    target.write_text(json.dumps(found, indent=0))


class Times:
    """The tests and their seconds, read again."""

    def __init__(self, path: Path, budget: float) -> None:
        self.seconds: dict[str, float] = json.loads(path.read_text())
        self.budget = budget

    def rounds(self, mutant: Mutant) -> list[list[str]]:
        """The tests of a mutant's room in two rounds: those of its own name, then the others."""
        path = Path(mutant.file).relative_to(SOURCE)
        places = tuple(f"tests/{name}/" for name in ROOMS[path.parts[0]])
        words = (*path.parts[1:-1], path.stem)  # its folders' names, then the file's own

        def likeness(name: str) -> int:
            file = Path(name.partition("::")[0]).stem
            return next((k for k, word in enumerate(words) if word in file), len(words))

        those = [name for name in self.seconds if name.startswith(places)]
        those.sort(key=lambda name: (likeness(name), self.seconds[name]))
        first = self.within([n for n in those if likeness(n) < len(words)], FIRST)
        rest = [name for name in those if name not in set(first)]
        return [tests for tests in (first, self.within(rest, self.budget - FIRST)) if tests]

    def within(self, names: list[str], budget: float) -> list[str]:
        """As many of the names as fit into so many seconds."""
        found, spent = [], 0.0
        for name in names:
            spent += self.seconds[name] + 0.005
            if spent > budget:
                break
            found.append(name)
        return found


class Copy:
    """The project beside itself, where mutants live."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("src", "tests", "cases", "reports"):
            skipped = shutil.ignore_patterns("__pycache__")
            shutil.copytree(TOP / name, folder / name, ignore=skipped)
        for name in ("pyproject.toml", "README.md", "CITATION.cff"):
            shutil.copy(TOP / name, folder / name)

    def outcome(self, mutant: Mutant, tests: Times) -> tuple[str, str]:
        """killed, slow or survived; and the test that failed."""
        rounds = tests.rounds(mutant)
        path = self.folder / mutant.file
        text = path.read_bytes()
        path.write_bytes(mutated(text, mutant))
        try:
            for names in rounds:
                limit = GRACE + PATIENCE * sum(tests.seconds[name] for name in names)
                failed = self.fails(names, int(limit))
                if failed is not None:
                    return ("slow" if failed == "" else "killed"), failed
        finally:
            path.write_bytes(text)
        return "survived", ""

    def fails(self, names: list[str], limit: int) -> str | None:
        """The first test that fails; empty where the time went out, None where none fails."""
        with tempfile.TemporaryFile("w+") as told:
            child = os.fork()
            if child == 0:
                self._test(names, limit, told.fileno())
            _, status = os.waitpid(child, 0)
            told.seek(0)
            text = told.read()
        if os.WIFSIGNALED(status):
            return ""
        code = os.WEXITSTATUS(status)
        if code == 0:
            return None
        if code in (4, 5):
            raise RuntimeError(text)
        named = [line for line in text.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return named[0] if named else f"exit {code}"

    def _test(self, names: list[str], limit: int, out: int) -> NoReturn:
        """In a child process, which imports polhode anew: nothing here has imported it."""
        code = 3
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
            os.dup2(out, 1)
            os.dup2(out, 2)
            os.chdir(self.folder)
            os.environ |= {"PYTHONPATH": "src", "PYTHONDONTWRITEBYTECODE": "1"}
            sys.path.insert(0, str(self.folder / "src"))
            sys.dont_write_bytecode = True
            code = pytest.main(["-x", "-n0", "-p", "no:cacheprovider", *names])
            sys.stdout.flush()
        finally:
            os._exit(code)


def run(tests: Times, target: Path, chosen: list[Mutant]) -> None:
    """Run what is not in the result yet; write it after every mutant."""
    results = json.loads(target.read_text()) if target.exists() else []
    known = {tuple(one["mutant"].values()) for one in results}
    with tempfile.TemporaryDirectory() as folder:
        project = Copy(Path(folder))
        for mutant in chosen:
            if tuple(mutant) in known:
                continue
            began = time.monotonic()
            outcome, by = project.outcome(mutant, tests)
            spent = round(time.monotonic() - began, 1)
            results.append({"mutant": mutant._asdict(), "outcome": outcome, "by": by, "s": spent})
            target.write_text(json.dumps(results, indent=1))
            print(line(results[-1]), flush=True)
    show(results)


def again(tests: Times, target: Path) -> None:
    """The survivors once more, on today's tests: only those whose place has not changed."""
    results = json.loads(target.read_text())
    with tempfile.TemporaryDirectory() as folder:
        project = Copy(Path(folder))
        for one in results:
            mutant = Mutant(**one["mutant"])
            text = (TOP / mutant.file).read_bytes()
            if one["outcome"] == "survived":
                if text[mutant.start : mutant.end].decode() != mutant.before:
                    print("moved:", line(one))
                    continue
                one["outcome"], one["by"] = project.outcome(mutant, tests)
                target.write_text(json.dumps(results, indent=1))
                print(line(one), flush=True)
    show(results)


def line(one: dict[str, Any]) -> str:
    mutant = Mutant(**one["mutant"])
    return (
        f"{one['outcome']:10} {mutant.file}:{mutant.line} {mutant.kind}: "
        f"{' '.join(mutant.before.split())} -> {mutant.after}  {one['by']}"
    )


def show(results: list[dict[str, Any]]) -> None:
    """The count of each outcome, by room, and every mutant that lives."""
    for room in (*ROOMS, ""):
        those = [r for r in results if f"polhode/{room}" in r["mutant"]["file"]]
        dead = sum(r["outcome"] in ("killed", "slow") for r in those)
        print(f"{room or 'all'}: {dead} of {len(those)} killed")
    for one in results:
        if one["outcome"] not in ("killed", "slow"):
            print(line(one))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["times", "run", "again", "show"])
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--package", nargs="+", choices=ROOMS, default=list(ROOMS))
    asked = parser.parse_args()
    match asked.what:
        case "times":
            take_times(asked.files[0], list(map(str, asked.files[1:])))
        case "run":
            chosen = drawn(asked.count, asked.seed, asked.package)
            run(Times(asked.files[0], BUDGET), asked.files[1], chosen)
        case "again":
            again(Times(asked.files[0], 10 * BUDGET), asked.files[1])
        case "show":
            show(json.loads(asked.files[0].read_text()))


if __name__ == "__main__":
    main()
