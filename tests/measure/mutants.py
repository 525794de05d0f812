"""Would a test notice?  Small random changes of the code, each run against the tests that touch it.

    python tests/measure/mutants.py map MAP.json [TESTS...]
    python tests/measure/mutants.py run MAP.json RESULT.json [--count 250] [--seed 1] [--package P]
    python tests/measure/mutants.py again MAP.json RESULT.json
    python tests/measure/mutants.py show RESULT.json

``map`` runs the fast tests (or the TESTS named) once under coverage.py (``pip install coverage``)
and writes down which test touches which line and how long it takes.  ``run`` draws mutants, all
places of all rooms equally likely, and runs on each one the tests that touch its line: the quickest
first, then the others, then their neighbours in the same files (which may read what a first test
left in a cache), until a test fails or about ``BUDGET`` seconds of tests have passed.  Each mutant
lives in a copy of the project, never in the project itself.  It is killed by a test that fails, or
that takes ``PATIENCE`` times its processor time.  The result is written after every mutant, and a
run that was interrupted goes on where it was.  ``again`` runs the survivors once more, on today's
tests.

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
from collections.abc import Iterator
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF
from typing import Any, NamedTuple

TOP = Path(__file__).parents[2]
SOURCE = Path("src/polhode")
ROOMS = ("numbers", "equations", "taylor", "judging", "closed_forms")
#: Tests whose processes are not followed (verbs), or that test no number (figures, pages), are not
#: among them.
TESTS = [f"tests/{name}" for name in ("numbers", "scenes", "equations", "judging", "taylor")]
TESTS += [f"tests/{name}" for name in ("closed_forms", "runs", "checks")]
FIRST = 25  # tests of the first round
BUDGET = 90  # seconds of tests a mutant
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


def drawn(count: int, seed: int, package: str | None) -> list[Mutant]:
    """Mutants drawn without repetition; no two of the same kind at the same place."""
    every = []
    for room in [package] if package else ROOMS:
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


class Coverage:
    """A plugin of pytest: which test touches which line, and its seconds of processor time."""

    def __init__(self, target: Path) -> None:
        import coverage

        self.target, self.written = target, time.monotonic()
        self.measured = coverage.Coverage(data_file=None, source=[str(TOP / SOURCE)])
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()
        self.measured.start()
        self.measured.switch_context("import")

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.measured.switch_context(nodeid)
        self.seconds[nodeid] = -spent()

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:  # it would kill every mutant
            self.failed.add(report.nodeid)

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.seconds[nodeid] += spent()
        if time.monotonic() > self.written + 60:
            self.write()

    def write(self) -> None:
        """The map as JSON: seconds by test, and tests (by number) by line."""
        names = [name for name, s in self.seconds.items() if name not in self.failed and s >= 0]
        number = {name: k for k, name in enumerate(names)}
        data, lines = self.measured.get_data(), {}
        for file in data.measured_files():
            rows = data.contexts_by_lineno(file)
            lines[str(Path(file).relative_to(TOP))] = {
                n: [number[name] for name in tests if name in number] for n, tests in rows.items()
            }
        held = {"tests": names, "seconds": self.seconds, "lines": lines}
        self.target.write_text(json.dumps(held))
        self.written = time.monotonic()


def spent() -> float:
    """Processor time of this process and of those that it waited for."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (RUSAGE_SELF, RUSAGE_CHILDREN))


def make_map(target: Path, tests: list[str]) -> None:
    """The map of these tests, written every minute."""
    import pytest

    sys.path.insert(0, str(TOP / "src"))
    plugin = Coverage(target)
    options = ["-p", "no:cacheprovider", "-n0", "-k", "not ctrl_c"]  # coverage swallows Ctrl-C
    pytest.main([*options, *(tests or TESTS)], plugins=[plugin])
    plugin.measured.stop()
    plugin.write()


class Map:
    """The map, read again."""

    def __init__(self, path: Path) -> None:
        held = json.loads(path.read_text())
        self.names, self.seconds = held["tests"], held["seconds"]
        self.lines = held["lines"]

    def rounds(self, mutant: Mutant) -> list[list[str]]:
        """The tests that touch a mutant's line, quickest first, in two rounds.

        A line that no test touches, but only the import, is touched by the tests of its file.
        """
        rows = self.lines.get(mutant.file, {})
        touching = {self.names[k] for k in rows.get(str(mutant.line), ())}
        if not touching and str(mutant.line) in rows:
            touching = {self.names[k] for tests in rows.values() for k in tests}
        files = {name.partition("::")[0] for name in touching}
        beside = [n for n in self.names if n.partition("::")[0] in files and n not in touching]
        order = sorted(touching, key=self.seconds.__getitem__)
        rest = [*order[FIRST:], *sorted(beside, key=self.seconds.__getitem__)]
        spent, found = sum(self.seconds[n] for n in order[:FIRST]), []
        for name in rest:
            spent += self.seconds[name]
            if spent > BUDGET:
                break
            found.append(name)
        return [tests for tests in (order[:FIRST], found) if tests]


class Copy:
    """The project beside itself, where mutants live."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("src", "tests", "cases", "reports"):
            skipped = shutil.ignore_patterns("__pycache__")
            shutil.copytree(TOP / name, folder / name, ignore=skipped)
        for name in ("pyproject.toml", "README.md", "CITATION.cff"):
            shutil.copy(TOP / name, folder / name)

    def outcome(self, mutant: Mutant, tests: Map) -> tuple[str, str]:
        """killed, slow, survived or untouched; and the test that failed."""
        rounds = tests.rounds(mutant)
        if not rounds:
            return "untouched", ""
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
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-n0", "-p", "no:cacheprovider", *names],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": "src", "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
        )
        if done.returncode == 0:
            return None
        if done.returncode in (4, 5):
            raise RuntimeError(done.stdout + done.stderr)
        lines = done.stdout.splitlines()
        named = [line for line in lines if line.startswith(("FAILED", "ERROR"))]
        if named:
            return named[0]
        return "" if done.returncode < 0 else f"exit {done.returncode}"


def run(tests: Map, target: Path, chosen: list[Mutant]) -> None:
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


def again(tests: Map, target: Path) -> None:
    """The survivors once more, on today's tests: only those whose place has not changed."""
    results = json.loads(target.read_text())
    with tempfile.TemporaryDirectory() as folder:
        project = Copy(Path(folder))
        for one in results:
            mutant = Mutant(**one["mutant"])
            text = (TOP / mutant.file).read_bytes()
            if one["outcome"] in ("survived", "untouched"):
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
    parser.add_argument("what", choices=["map", "run", "again", "show"])
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--package", choices=ROOMS)
    asked = parser.parse_args()
    match asked.what:
        case "map":
            make_map(asked.files[0], list(map(str, asked.files[1:])))
        case "run":
            chosen = drawn(asked.count, asked.seed, asked.package)
            run(Map(asked.files[0]), asked.files[1], chosen)
        case "again":
            again(Map(asked.files[0]), asked.files[1])
        case "show":
            show(json.loads(asked.files[0].read_text()))


if __name__ == "__main__":
    main()
