"""The reference of the package's public names, made of their documentation."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib import import_module

from polhode.common.errors import BadInput, nearest

_ROLE = re.compile(r":\w+:`~?([^`]+)`")


def names() -> list[str]:
    """The public names, functions before classes."""
    every = (name for name in import_module("polhode").__all__ if not name.startswith("_"))
    return sorted(every, key=lambda name: (name[0].isupper(), name))


def table() -> list[str]:
    """Every public name with the first sentence of its documentation."""
    package = import_module("polhode")
    lines = ["| name | |", "|---|---|"]
    for name in names():
        thing = getattr(package, name)
        told = _text(thing).split("\n\n")[0]
        called = "" if inspect.isclass(thing) else "()"
        sentence = re.split(r"(?<=[.;])\s", " ".join(told.split()))[0].rstrip(".;")
        lines.append(f"| `polhode.{name}{called}` | {_plain(sentence)} |")
    return lines


def page(name: str) -> str:
    """One name as Markdown: how it is called, its documentation; of a class its members too.

    Raises BadInput for a name that there is not.
    """
    if name not in names():
        raise BadInput("guide", "api", name, nearest(name, names()))
    thing = getattr(import_module("polhode"), name)
    parts = [f"# polhode.{name}", _called(f"polhode.{name}", thing), _documentation(thing)]
    if inspect.isclass(thing):
        members = [*_members(thing)]
        parts += ["## Members"] * bool(members) + members
    return "\n\n".join(part for part in parts if part)


def _text(thing: object) -> str:
    return inspect.getdoc(thing) or ""


def _plain(text: str) -> str:
    return _ROLE.sub(r"`\1`", text.replace("``", "`"))


def _called(name: str, thing: object) -> str:
    """How it is called, one argument per line; nothing for what is not called by its users."""
    if not inspect.isroutine(thing):
        return ""
    signature = inspect.signature(thing)
    lines = [f"    {parameter}," for parameter in _arguments(signature)]
    returned = signature.return_annotation
    arrow = f" -> {returned}" if isinstance(returned, str) else ""
    inside = "\n".join([f"{name}(", *lines, f"){arrow}"]) if lines else f"{name}(){arrow}"
    return f"```python\n{inside}\n```"


def _arguments(signature: inspect.Signature) -> Iterator[str]:
    """The arguments as they are written, with the star before those that have to be named."""
    starred = False
    for parameter in signature.parameters.values():
        if parameter.name == "self":
            continue
        keyword = parameter.kind is inspect.Parameter.KEYWORD_ONLY
        if keyword and not starred:
            starred = True
            yield "*"
        starred = starred or parameter.kind is inspect.Parameter.VAR_POSITIONAL
        kind = parameter.annotation
        text = f"{parameter}" if not isinstance(kind, str) else f"{parameter}".replace("'", "")
        yield text


def _documentation(thing: object) -> str:
    """What ``help`` says of it."""
    return f"```text\n{_plain(_text(thing))}\n```"


def _members(thing: type) -> Iterator[str]:
    """The public methods and properties of a class, each with its whole documentation."""
    for name, member in sorted(vars(thing).items()):
        if name.startswith("_"):
            continue
        inner = getattr(member, "__func__", member)
        if not _text(inner) or not hasattr(inner, "__get__"):
            continue
        yield f"### {name}"
        if callable(inner):
            yield _called(name, inner)
        yield _documentation(inner)
