"""The options of a verb, made of the source of its function: annotations and numpydoc docstring.

The source is read as text, so that ``--help`` and a wrong option import nothing of the physics.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
from argparse import SUPPRESS, ArgumentParser, ArgumentTypeError, BooleanOptionalAction
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

PACKAGE = Path(__file__).parents[1]


class Parameter(NamedTuple):
    """A parameter as the source has it: annotation without ``None``, default empty for none."""

    name: str
    annotation: str
    default: str


class Front(NamedTuple):
    """A function as its source tells it: parameters, and the first sentence about each of them.

    ``several``: its parameter ``*name``, "" for none.
    """

    name: str
    parameters: Sequence[Parameter]
    helps: Mapping[str, str]
    several: str = ""


def _helps(documented: ast.FunctionDef | ast.ClassDef) -> dict[str, str]:
    """The first sentence that a docstring says of each parameter."""
    docstring = inspect.cleandoc(ast.get_docstring(documented) or "")
    part = docstring.partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    entries = re.findall(r"^([\w*, ]+) : .*\n((?: .*\n?)+)", part + "\n", re.M)
    return {
        name.strip(" *"): _first_sentence(text)
        for names, text in entries
        for name in names.split(",")
    }


def _first_sentence(text: str) -> str:
    sentence = re.match(r"(.*?)[.:;]?(?:(?<=\.)\s|$)", " ".join(text.split()))
    said = (sentence[1] if sentence else "").replace("``", "")
    return re.sub(r":\w+:`polhode\.(\w+)`", r"\1", said)


def front(home: str, name: str) -> Front:
    """The function of this name in a module of polhode; of overloads the one with a body."""
    statements = _statements(home)
    *_, function = (x for x in statements if isinstance(x, ast.FunctionDef) and x.name == name)
    arguments, helps = function.args, _helps(function)
    positional = [*arguments.posonlyargs, *arguments.args]
    lacking = len(positional) - len(arguments.defaults)
    defaults = [*[None] * lacking, *arguments.defaults, *arguments.kw_defaults]
    pairs = zip([*positional, *arguments.kwonlyargs], defaults, strict=True)
    parameters = [_parameter(x, default) for x, default in pairs]
    others = "" if arguments.kwarg is None else _parameter(arguments.kwarg, None).annotation
    if shared := re.fullmatch(r"Unpack\[(\w+)\]", others):
        options = _class(home, shared[1])
        parameters += [_field(x) for x in options.body if isinstance(x, ast.AnnAssign)]
        helps |= _helps(options)
    if arguments.vararg is None:
        return Front(name, parameters, helps)
    several = _parameter(arguments.vararg, None)
    first = Parameter(several.name, f"Sequence[{several.annotation}]", "()")
    return Front(name, [first, *parameters], helps, several.name)


def _statements(home: str) -> list[ast.stmt]:
    source = PACKAGE.joinpath(*home.split(".")[1:]).with_suffix(".py").read_text("utf-8")
    return ast.parse(source).body


def _class(home: str, name: str) -> ast.ClassDef:
    """The class of this name that a module has, or imports."""
    for x in _statements(home):
        if isinstance(x, ast.ClassDef) and x.name == name:
            return x
        if isinstance(x, ast.ImportFrom) and x.module and name in (y.name for y in x.names):
            return _class(x.module, name)
    raise LookupError(name)


def _parameter(argument: ast.arg, default: ast.expr | None) -> Parameter:
    annotation = "" if argument.annotation is None else ast.unparse(argument.annotation)
    value = "" if default is None else ast.unparse(default)
    return Parameter(argument.arg, annotation.removesuffix(" | None"), value)


def _field(field: ast.AnnAssign) -> Parameter:
    """A key of a TypedDict, which may be left out."""
    name, annotation = ast.unparse(field.target), ast.unparse(field.annotation)
    default = "False" if annotation == "bool" else "None"
    return Parameter(name, annotation.removesuffix(" | None"), default)


# -- how the text of an option is read ------------------------------------------------------------


def whole(text: str) -> int:
    """A whole number."""
    try:
        if len(text) > 18 and text.strip("+-0123456789_ ") == "":
            raise ArgumentTypeError(f"a whole number of at most 18 digits, not {text[:40]!r}")
        return int(text[:40])  # a longer one is none
    except ValueError:
        raise ArgumentTypeError(f"a whole number, not {text[:40]!r}") from None


def positive(text: str) -> int:
    """A whole number above 0."""
    number = whole(text)
    if number < 1:
        raise ArgumentTypeError(f"1 or more, not {number}")
    return number


def real(text: str) -> float:
    """A finite number that is read as a double."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ArgumentTypeError(f"a number, not {text[:40]!r}")
    return number


def word(text: str) -> str:
    """A name of a case or a file, or any other word."""
    if not text:
        raise ArgumentTypeError("a name, not ''")
    return text


def names(text: str) -> list[str]:
    """Names between commas."""
    words = [name.strip() for name in text.split(",")]
    if "" in words:
        raise ArgumentTypeError(f"names with commas between, not {text[:40]!r}")
    return words


def words(text: str) -> list[str]:
    """Names between commas, none of an empty text."""
    return names(text) if text else []


def grid(text: str) -> tuple[int, int]:
    """NxM."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip())
    if match is None or int(match[1]) * int(match[2]) == 0:
        raise ArgumentTypeError(f"NxM, such as 9x8, not {text[:40]!r}")
    return int(match[1]), int(match[2])


class Kind(NamedTuple):
    """How an option of one type is written: its placeholder, and what reads its text."""

    metavar: str
    read: Callable[[str], Any]
    more: Mapping[str, Any] = {}


_REPEATED = {"action": "append"}

#: By annotation without ``None``.  Numbers of a scene stay text: the function reads them, exactly
#: and in the scene's units, as it does in Python.  A parameter of another type is Python's alone.
KINDS = {
    "int": Kind("N", positive),
    "float": Kind("X", real),
    "str": Kind("WORD", str),
    "str | NumberType": Kind("TYPE", str),
    "AnyNumber": Kind("X", str),
    "Iterable[AnyNumber]": Kind("X,X...", names),
    "Iterable[str]": Kind("NAME,NAME...", words),
    "Sequence[str]": Kind("NAME,NAME...", names),
    "list[str]": Kind("WHAT", str, _REPEATED),
    "tuple[int, int]": Kind("NxM", grid),
    "vary.Vary": Kind("KEY=FROM:TO:N", str, _REPEATED),
    "Iterable[AnyVector] | str": Kind("FILE", word),
}


def kind_of(annotation: str) -> Kind | None:
    """How an option for such a parameter is written, if there is one."""
    if {"str", "Path"} <= {*annotation.split(" | ")}:
        metavars = [x for x, y in (("SCENE", "Scene"), ("FILE", "Trajectory")) if y in annotation]
        return Kind("|".join(metavars) or "FILE", word)
    if choices := re.fullmatch(r"Literal\[(.*)\]", annotation):
        words = [choice.strip(" \"'") for choice in choices[1].split(",")]
        return Kind("|".join(words), str, {"choices": words})
    return KINDS.get(annotation)


def add(parser: ArgumentParser, function: Front, named: Mapping[str, str | None]) -> None:
    """Add an option for each parameter that may be one; the first, if it is needed, an argument.

    ``named``: another name for some; one without dashes is an argument; None for none.
    """
    helps = function.helps
    for place, parameter in enumerate(function.parameters):
        dashes = "" if place == 0 and _is_argument(parameter) else "--"
        option = named.get(parameter.name, f"{dashes}{parameter.name.replace('_', '-')}")
        if option is None:
            continue
        if option.startswith("-"):
            _option(parser, parameter, option, helps.get(parameter.name))
        else:
            _positional(parser, parameter, helps.get(parameter.name))


def _is_argument(parameter: Parameter) -> bool:
    return not parameter.default or parameter.annotation.startswith("Sequence[")


def _positional(parser: ArgumentParser, parameter: Parameter, meanings: str | None) -> None:
    several = parameter.annotation.startswith("Sequence[")
    inner = parameter.annotation.removeprefix("Sequence[").removesuffix("]" if several else "")
    kind = kind_of(inner) or Kind(parameter.name.upper(), word)
    more: dict[str, Any] = {"nargs": "*" if parameter.default else "+"} if several else {}
    metavar = "SCENE" if parameter.name == "scene" else kind.metavar
    parser.add_argument(parameter.name, type=kind.read, metavar=metavar, help=meanings, **more)


def _option(
    parser: ArgumentParser, parameter: Parameter, option: str, meanings: str | None
) -> None:
    text = None if meanings is None else meanings.replace("%", "%%")
    common: dict[str, Any] = {"dest": parameter.name, "help": text, "default": SUPPRESS}
    kinds = {*parameter.annotation.split(" | ")}
    if kinds == {"bool"}:
        flag = "store_true" if parameter.default == "False" else BooleanOptionalAction
        parser.add_argument(option, action=flag, **common)
        return
    if kinds == {"bool", "int"}:
        either = parser.add_mutually_exclusive_group()
        either.add_argument(option, type=positive, metavar="N", **common)
        common["help"] = f"never {option[2:]}"
        either.add_argument(f"--no-{option[2:]}", action="store_false", **common)
        return
    kind = kind_of(parameter.annotation)
    if kind is not None:
        common |= kind.more if "choices" in kind.more else {"type": kind.read, **kind.more}
        required = not parameter.default
        parser.add_argument(option, metavar=kind.metavar, required=required, **common)
