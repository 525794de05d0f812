"""The first minutes: a welcome, a version, which extra is missing, completion, how to cite."""

from __future__ import annotations

import json
import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest

import polhode
from polhode import cli
from polhode.cli import main
from polhode.common import provenance

TOP = Path(__file__).parents[2]


def said(capsys, *arguments, code=0):
    assert main([*arguments]) == code
    output = capsys.readouterr()
    return output.out if code == 0 else output.err


def test_alone_it_says_what_it_is_and_three_commands_that_exist(capsys):
    output = said(capsys)
    assert len(output.splitlines()) <= 10
    commands = re.findall(r"^  polhode (.*?)(?:  |$)", output, re.M)
    assert len(commands) == 3
    for command in commands:
        words = shlex.split(command)
        options, rest = cli._parser(words).parse_known_args(words)
        assert not rest
        if getattr(options, "scene", None):
            polhode.load(options.scene)


def test_its_version(capsys):
    with pytest.raises(SystemExit) as ending:
        main(["--version"])
    assert ending.value.code == 0
    assert capsys.readouterr().out.strip() == f"polhode {polhode.__version__}"


def test_every_extra_that_is_named_is_there_and_quoted():
    """An unquoted bracket is a pattern in zsh."""
    with (TOP / "pyproject.toml").open("rb") as file:
        extras = set(tomllib.load(file)["project"]["optional-dependencies"])
    named = set()
    for path in (TOP / "src").rglob("*.py"):
        for before, extra in re.findall(r"pip install (.?)polhode\[([\w-]+)\]", path.read_text()):
            assert before in "'\"", path
            named.add(extra)
    assert {"figures", "frames", "shell"} <= named <= extras


def test_axes_are_shown_as_rows_of_numbers(capsys):
    """They were Python's lists of texts."""
    output = said(capsys, "show", "lagrange/turned-axes")
    (line,) = (line for line in output.splitlines() if line.startswith("axes"))
    assert (line.count("["), line.count("'")) == (3, 0)


def test_the_citation_is_one_record(capsys):
    assert (TOP / "CITATION.cff").read_text(encoding="utf-8") == provenance.cff()
    assert f"version: {polhode.__version__}\ndate-released: " in provenance.cff()
    version, date = polhode.__version__, provenance.RELEASED
    assert f"\nVersion {version} ({date}) · " in (TOP / "README.md").read_text(encoding="utf-8")
    assert f"\n## {version} ({date})\n" in (TOP / "CHANGELOG.md").read_text(encoding="utf-8")
    output = said(capsys, "about", "--cite")
    assert output.count("\n@") == 1
    assert f"version = {{{polhode.__version__}}}" in output
    assert json.loads(said(capsys, "about", "--cite", "--json"))["bibtex"] == provenance.bibtex()


def test_a_shell_completes_verbs_and_options(capsys, monkeypatch):
    pytest.importorskip("shtab")
    for shell in ("bash", "zsh"):
        output = said(capsys, "--print-completion", shell)
        assert "--max-steps" in output
        assert "compare" in output
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert "pip install 'polhode[shell]'" in said(capsys, "--print-completion", "bash", code=2)
