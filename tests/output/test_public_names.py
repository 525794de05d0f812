"""The public names: all listed, their documentation complete and as the signatures are."""

from __future__ import annotations

import inspect
import re

import pytest

import polhode
from polhode import cli

NAMES = [name for name in polhode.__all__ if not name.startswith("_")]
FUNCTIONS = [name for name in NAMES if inspect.isroutine(getattr(polhode, name))]


def sections(text: str) -> dict[str, str]:
    _, *parts = re.split(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", text, flags=re.M)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def entries(section: str) -> list[str]:
    heads = [line.partition(" : ")[0] for line in section.splitlines() if re.match(r"\S", line)]
    return [name.strip() for head in heads for name in head.split(",")]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_of_a_public_function_is_told_once_and_nothing_else(name):
    function = getattr(polhode, name)
    told_sections = sections(inspect.getdoc(function))
    signature = inspect.signature(function)
    returns = ["Returns"] if signature.return_annotation != "None" else []
    takes = ["Parameters"] if signature.parameters else []
    assert {*takes, *returns, "Raises", "Examples"} <= set(told_sections)
    assert ("Returns" in told_sections) == bool(returns)
    parameters = [
        {p.VAR_KEYWORD: "**", p.VAR_POSITIONAL: "*"}.get(p.kind, "") + p.name
        for p in signature.parameters.values()
    ]
    assert sorted(entries(told_sections.get("Parameters", ""))) == sorted(parameters)
    for kind in (*returns, "Raises"):
        assert entries(told_sections[kind])
    assert told_sections["Examples"].startswith(">>> ")
    for section in (*takes, *returns, "Raises"):
        for entry in re.split(r"\n(?=\S)", told_sections[section].strip()):
            assert "\n    " in entry, f"{name}: nothing is said of {entry}"


def test_the_guide_lists_every_public_name(capsys):
    assert cli.main(["guide", "python"]) == 0
    listed = re.findall(r"^\| `polhode\.(\w+)", capsys.readouterr().out, re.M)
    assert listed == sorted(NAMES, key=lambda name: (name[0].isupper(), name))
