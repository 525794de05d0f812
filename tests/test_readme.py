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
from typing import NamedTuple

import pytest

from polhode import cli

README = (Path(__file__).parents[1] / "README.md").read_text()


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
#: Lines of a table: `polhode VERB ...` between bars.
VERBS = re.findall(r"^\| `polhode (\w+)([^`]*)` \|", README, re.M)


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
    assert len(SESSIONS) == 2
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


def test_the_table_of_verbs_is_the_programs(capsys: pytest.CaptureFixture[str]) -> None:
    """Each verb once, and no option that the verb has not."""
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    told = capsys.readouterr().out
    assert [verb for verb, _ in VERBS] == re.findall(r"^    (\w+)\b", told, re.M)
    for verb, usage in VERBS:
        with pytest.raises(SystemExit):
            cli.main([verb, "--help"])
        told = capsys.readouterr().out
        for option in re.findall(r"(?<!\w)--?[a-z][a-z-]*", usage):
            assert re.search(rf"^  {option}\b", told, re.M), (verb, option)


def test_every_name_of_python_that_is_named_exists() -> None:
    names = re.findall(r"`polhode((?:\.[a-z_]+)+)\(", README)
    assert len(names) >= 4
    for name in names:
        found = importlib.import_module("polhode")
        for part in name[1:].split("."):
            found = getattr(found, part)


def test_numbers_from_the_report_are_those_of_the_report() -> None:
    """``python tests/measure/readme.py`` puts them in."""
    from measure import readme

    assert readme.put_in(README) == README
    for name, part in readme.parts().items():
        assert len(part) > 100, name
        assert part in README
