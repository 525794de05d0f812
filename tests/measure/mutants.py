"""Would a test notice?  Faults made by hand, each run against the fast tests of its room.

    python tests/measure/mutants.py MUTANTS.json RESULT.json [PYTEST ARGUMENTS...]

MUTANTS.json is a list of objects with an ``id``, a ``file``, ``old`` and ``new``, a text that
stands there once and what it becomes, and ``tests``, the folders and files to run: those that are
named like the changed one or its folder come first.  ``mutants.json`` beside this is such a list;
``checker.json`` has each inequality and each term of ``certificates/verify.py``, left out or
weakened, and where that cannot make a false claim pass, ``cannot`` says why.
Each mutant lives in a copy of the project, never in the project itself.  It is killed by a test
that fails, or where the tests take LIMIT seconds of processor time.  The result is written after
every mutant, and a run that was interrupted goes on where it was.

Nothing here passes or fails by itself: survivors are for a reader, who writes a test, or names the
reason why no test can tell the mutant from the code.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

TOP = Path(__file__).parents[2]
LIMIT = 900


class Mutant(NamedTuple):
    """One change of a file; ``why``: the fault that it stands for.

    ``cannot``: why no test can tell it from the code; empty where one has to.
    """

    id: str
    file: str
    old: str
    new: str
    tests: list[str]
    why: str = ""
    cannot: str = ""


class Copy:
    """The project beside itself, where mutants live."""

    def __init__(self, folder: Path, options: list[str]) -> None:
        self.folder, self.options = folder, options
        for name in ("src", "tests", "cases", "reports"):
            skipped = shutil.ignore_patterns("__pycache__")
            shutil.copytree(TOP / name, folder / name, ignore=skipped)
        for name in ("pyproject.toml", "README.md", "CITATION.cff"):
            shutil.copy(TOP / name, folder / name)

    def outcome(self, mutant: Mutant) -> tuple[str, str]:
        """gone, killed, slow or survived; and the test that failed."""
        path = self.folder / mutant.file
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if text.count(mutant.old) != 1:
            return "gone", f"stands there {text.count(mutant.old)} times"
        path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        try:
            return self._tested(self._files(mutant))
        finally:
            path.write_text(text, encoding="utf-8")

    def _files(self, mutant: Mutant) -> list[str]:
        """The files of a mutant's tests, those of its own name first."""
        _, _, *folders, name = Path(mutant.file).parts
        words = (*folders, Path(name).stem)
        places = [self.folder / name for name in mutant.tests]
        every = [x for x in places if x.is_file()]
        every += [file for x in places if x.is_dir() for file in x.rglob("test_*.py")]
        every.sort(key=lambda file: (not any(word in file.stem for word in words), file))
        return [*map(str, every)]

    def _tested(self, files: list[str]) -> tuple[str, str]:
        process = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-n0", *self.options, *files],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": "src:tests", "PYTHONDONTWRITEBYTECODE": "1"},
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT)),
            capture_output=True,
            text=True,
        )
        if process.returncode < 0:
            return "slow", ""
        if process.returncode == 0:
            return "survived", ""
        named = [x for x in process.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
        if not named:
            raise RuntimeError(process.stdout + process.stderr)
        return "killed", named[0]


def main(listed: Path, target: Path, options: list[str]) -> None:
    """Run what is not in the result yet; then the count, and every mutant that lives."""
    chosen = [Mutant(**row) for row in json.loads(listed.read_text())]
    results = json.loads(target.read_text()) if target.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        project = Copy(Path(folder), options)
        for mutant in chosen:
            if mutant.id not in results:
                results[mutant.id] = project.outcome(mutant)
                target.write_text(json.dumps(results, indent=1))
                print(mutant.id, *results[mutant.id], flush=True)
    outcomes = [results[mutant.id][0] for mutant in chosen]
    alike = sum(bool(mutant.cannot) for mutant in chosen)
    noticed = outcomes.count("killed") + outcomes.count("slow")
    print(f"{noticed} of {len(chosen)} killed; of {alike} a reason is told why none can be")
    for mutant in chosen:
        if results[mutant.id][0] in ("survived", "gone") and not mutant.cannot:
            print(f"{results[mutant.id][0]}: {mutant.id}, {mutant.file}: {mutant.why}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
