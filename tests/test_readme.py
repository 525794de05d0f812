"""The README: its commands and its Python are run, and print what stands there."""

from __future__ import annotations

import importlib
import os
import re
import shlex
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from polhode import conditioning
from polhode.output import guide
from polhode.scenes import library

TOP = Path(__file__).parents[1]
README = (TOP / "README.md").read_text(encoding="utf-8")


class Block(NamedTuple):
    """A fenced block: its language, its text, and the paragraph before it."""

    language: str
    text: str
    before: str


def blocks() -> list[Block]:
    """The fenced blocks, in order."""
    texts = re.split(r"^```(\w*)\n", README, flags=re.M)
    return [
        Block(texts[k], texts[k + 1], texts[k - 1].strip().rpartition("\n\n")[2])
        for k in range(1, len(texts), 4)
    ]


BLOCKS = blocks()
SESSIONS = [block for block in BLOCKS if block.text.startswith("$ ")]
#: A block of Python, and the block of what it prints.
PYTHON = [(one, other) for one, other in pairwise(BLOCKS) if one.language == "python"]
MOST_LINES, MOST_COLUMNS = 110, 120  # two screens
#: The lines that may be longer: commands to be copied, what programs print, addresses.
_LONG = re.compile(r"^(    python3|[\w.]+: |motion |<p>|\| )")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty folder with the files that the README shows, under the names that it gives them."""
    made = tmp_path_factory.mktemp("readme")
    for block in BLOCKS:
        if block.language == "toml":
            (name,) = re.findall(r"`([\w-]+\.toml)`", block.before)
            (made / name).write_text(block.text)
    return made


def printed(arguments: list[str], folder: Path) -> str:
    """What a command prints on a terminal, both streams in order."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def without_seconds(text: str) -> str:
    """Times of computing are not the same twice."""
    return re.sub(r"\b[\d.]+ m?s\b", "some s", text)


def polhode(command: str, folder: Path) -> str:
    program, *arguments = shlex.split(command)
    assert Path(program).name == "polhode"
    return printed(["-m", "polhode", *arguments], folder)


def test_the_readme_shows_what_this_file_looks_for() -> None:
    assert len(SESSIONS) == 1
    assert len(PYTHON) == 1
    assert sum(block.language == "toml" for block in BLOCKS) == 1
    assert len(BLOCKS) == len(SESSIONS) + 2 * len(PYTHON) + 1


@pytest.mark.slow
def test_each_command_prints_what_stands_there(folder: Path) -> None:
    """In their order, as the later ones judge what the first ones wrote."""
    for block in SESSIONS:
        for session in re.split(r"^\$ ", block.text, flags=re.M)[1:]:
            command, _, expected = session.partition("\n")
            assert without_seconds(polhode(command, folder)) == without_seconds(expected), command


@pytest.mark.slow
@pytest.mark.parametrize(("block", "expected"), PYTHON)
def test_each_block_of_python_prints_what_stands_there(
    folder: Path, block: Block, expected: Block
) -> None:
    assert without_seconds(printed(["-c", block.text], folder)) == without_seconds(expected.text)


def test_the_first_command_runs_its_main_job(tmp_path: Path) -> None:
    """All of the one line but for the environment and pip, which the project's CI goes through."""
    lines = [line.strip() for line in README.splitlines() if line.startswith("    python3 -m venv")]
    first, second = (line.split(" && ") for line in lines)
    assert [part.split()[0] for part in first[:2]] == ["python3", ".venv/bin/pip"]
    assert [part.split()[0] for part in second] == ["python3", ".venv/bin/pip", ".venv/bin/python"]
    for command in first[2:]:
        assert polhode(command, tmp_path)
    assert (tmp_path / "brick.csv").exists()


def test_it_fits_on_two_screens_and_links_to_what_there_is() -> None:
    lines = README.splitlines()
    assert len(lines) <= MOST_LINES
    assert [x for x in lines if len(x) > MOST_COLUMNS and not _LONG.match(x)] == []
    targets = re.findall(r"\]\(((?!http)[^)]+)\)|src=\"([^\"]+)\"", README)
    assert len(targets) > 15
    for target in (one or other for one, other in targets):
        assert (TOP / target).is_file(), target
    pages = {f"src/polhode/guide/{topic}.md" for topic in guide.topics()}
    assert pages <= {one for one, _ in targets}


def test_every_name_of_python_that_is_named_exists() -> None:
    names = re.findall(r"`polhode((?:\.[a-z_]+)+)\(", README)
    assert len(names) >= 2
    for name in names:
        found = importlib.import_module("polhode")
        for part in name[1:].split("."):
            found = getattr(found, part)


def test_numbers_from_the_report_are_those_of_the_report() -> None:
    """``python tests/measure/readme.py`` puts them in."""
    from measure import readme

    for path in set(readme.PLACES.values()):
        text = path.read_text(encoding="utf-8")
        assert readme.put_in(text, path) == text
    for name, part in readme.parts().items():
        assert len(part) > 100, name
        assert part in readme.PLACES[name].read_text(encoding="utf-8")


#: What is not another program: polhode's trajectories, and its engine.
OWN = ("polhode integrate", "heyoka by hand")


def stand(level: Any) -> str:
    """Where a propagator stands at a level of a cell, from the programs' rows."""
    rows = {row["program"]: row for row in level["programs"]}
    if rows.pop("polhode propagator")["reached"] < 7:
        return "not reached"
    for own in OWN:
        rows.pop(own, None)
    ratios = [row["ratio"] for row in rows.values() if row["ratio"] is not None]
    if not ratios:
        return "alone"
    _, least, most = min(ratios)
    return "ahead" if least > 1 else "behind" if most < 1 else "even"


def test_who_is_ahead_is_counted_from_the_rows() -> None:
    """The README's counts, and whom it names, again from the rows of the programs."""
    from polhode.studies import report

    cells = report.results(TOP / "reports", "speed")["cells"]
    text = " ".join(README.split())
    for where, least, most in (("from t = 100 on", 100, 1e9), ("at t = 1 and 10", 0, 10)):
        here = [c for c in cells if least <= c["end"] <= most]
        stands = [stand(level) for c in here for level in c["levels"]]
        found = re.search(
            rf"{where} in (\d+) of (\d+) cells(?: \(([^)]*)\))?",
            text,
        )
        assert found is not None, where
        ahead, reached, others = found.groups()
        assert int(ahead) == stands.count("ahead")
        assert int(reached) == sum(stands.count(word) for word in ("ahead", "even", "behind"))
        for word, told in (
            ("even", "even"),
            ("behind", "behind"),
            ("alone", "more that no other program run there reaches"),
            ("not reached", "that it does not reach"),
        ):
            if stands.count(word):
                assert f"{stands.count(word)} {told}" in others
    lost = [
        (row["ratio"][0], row["program"])
        for c in cells
        for level in c["levels"]
        if stand(level) == "behind"
        for row in level["programs"]
        if row["ratio"] is not None
        and row["program"] not in ("polhode integrate", "heyoka by hand")
    ]
    assert lost
    least, name = min(lost)
    assert f"({name} {least:.2f})" in text


def test_what_the_example_multiplies_errors_by(folder: Path) -> None:
    """In README and guide, as the scene's conditioning has it."""
    (path,) = folder.glob("*.toml")
    scene = library.load(str(path))
    (*_, power) = conditioning(scene).log10_amplification
    expected = f"{10**power:.1e}".replace("e+0", "e")
    for text in (README, guide.page("judging")):
        assert re.findall(r"multiplies errors by (\S+?);? ", text) == [expected]


def test_what_was_withdrawn_is_said_in_the_changelog() -> None:
    text = " ".join((TOP / "CHANGELOG.md").read_text(encoding="utf-8").split())
    assert 'Withdrawn until speed is measured again: "12 of 12 cells"' in text
    assert "12 of 12" not in README
