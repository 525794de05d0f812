"""The reference of the public names: complete, and as the signatures are."""

from __future__ import annotations

import inspect
import json
import re

import pytest

import polhode
from polhode import cli
from polhode.output import api_reference

FUNCTIONS = [name for name in api_reference.names() if inspect.isroutine(getattr(polhode, name))]


def sections(text: str) -> dict[str, str]:
    _, *parts = re.split(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", text, flags=re.M)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def entries(section: str) -> list[str]:
    heads = [line.partition(" : ")[0] for line in section.splitlines() if re.match(r"\S", line)]
    return [name.strip() for head in heads for name in head.split(",")]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_of_a_public_function_is_told_once_and_nothing_else(name):
    function = getattr(polhode, name)
    found = sections(inspect.getdoc(function))
    returns = ["Returns"] if inspect.signature(function).return_annotation != "None" else []
    assert {"Parameters", *returns, "Raises", "Examples"} <= set(found)
    assert ("Returns" in found) == bool(returns)
    asked = [
        {p.VAR_KEYWORD: "**", p.VAR_POSITIONAL: "*"}.get(p.kind, "") + p.name
        for p in inspect.signature(function).parameters.values()
    ]
    told = entries(found["Parameters"])
    assert sorted(told) == sorted(asked)
    for kind in (*returns, "Raises"):
        assert entries(found[kind])
    assert found["Examples"].startswith(">>> ")
    for section in ("Parameters", *returns, "Raises"):
        for entry in re.split(r"\n(?=\S)", found[section].strip()):
            assert "\n    " in entry, f"{name}: nothing is said of {entry}"


@pytest.mark.parametrize("name", api_reference.names())
def test_every_public_name_has_a_page(name):
    page = api_reference.page(name)
    assert page.startswith(f"# polhode.{name}\n")
    assert ":func:" not in page
    assert ">>> " in page
    if name in FUNCTIONS:
        for argument in inspect.signature(getattr(polhode, name)).parameters:
            assert re.search(rf"^    \**{argument}[,:]", page, re.M), argument


def test_the_verb_prints_names_and_members(capsys):
    assert cli.main(["guide", "api"]) == 0
    listed = re.findall(r"^\| `polhode\.(\w+)", capsys.readouterr().out, re.M)
    assert listed == api_reference.names()
    assert cli.main(["guide", "api", "Trajectory", "--json"]) == 0
    text = json.loads(capsys.readouterr().out)["text"]
    assert "### angles_at" in text
    assert "    t: AnyNumber" in text
