"""Right scenes, tables, commands and calls gone wrong, as strategies of hypothesis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import strategies as st

import polhode
from fuzz import values
from polhode import cli
from polhode.output import new_scene
from polhode.scenes import vocabulary
from shared.motions import free_file


class Case(NamedTuple):
    """Files of a folder, and a command or a call in it for :mod:`fuzz.promise`."""

    said: str
    files: dict[str, bytes]
    work: list[str] | Callable[[], Any]


#: Right scenes: every key of the format, an event, published values, parts.
NAMES = ("published/basilisk-momentum-axes", "published/curtis", "published/detest-b5")
NAMES += ("lagrange/homoclinic", "euler/angles-start", "general/section", "lagrange/nutation")
FREE = free_file("end = 1\nsamples = 3\n[expect]\ndouble = [12, 17]")
CONE = new_scene.of_shape("cone", ["3 cm", "5 cm", "50 g"], "pi/6", "9", "1", "cone.toml")
SCENES = [FREE, CONE, *(polhode.load(name).source for name in NAMES)]
WORDS = sorted(
    {key.name for section in vocabulary.KEYS.values() for key in section} | {'"a b"', "x"}
)
HEADS = [f"[{section}]" for section in vocabulary.KEYS] + ["[[events]]", "[[published]]", "[x]"]
TABLE = b"t,p,q,r\n0,0.3,-0.4,1.1\n"
FILES = {"top.toml": FREE.encode(), "table.csv": TABLE, "latin.csv": b"t,p\n0,\xe9\n"}


def of(options: Any) -> st.SearchStrategy[Any]:
    return st.sampled_from(list(options))


def several(most: int) -> st.SearchStrategy[range]:
    return st.integers(1, most).map(range)


PIECES = [bytes([x]) for x in b'[]{}=,#."\\-\r\0'] + [b"\r\n", b"\xff\xfe", b"\xef\xbb\xbf"]


@st.composite
def mangled(draw: st.DrawFn, text: bytes) -> bytes:
    """Bytes changed, left out, doubled, put in."""
    data = bytearray(text)
    for _ in draw(several(4)):
        at = draw(st.integers(0, len(data)))
        match draw(st.integers(0, 5)):
            case 0:
                data[at : at + 1] = bytes([draw(st.integers(0, 255))])
            case 1:
                del data[at : at + draw(of((1, 3, 40)))]
            case 2:
                data[at:at] = data[at : at + 40]
            case 3:
                del data[at:]
            case _:
                data[at:at] = draw(of(PIECES))
    return bytes(data)


def sometimes_mangled(text: bytes) -> st.SearchStrategy[bytes]:
    return st.one_of(st.just(text), st.just(text), mangled(text))


@st.composite
def scene(draw: st.DrawFn) -> Case:
    """A scene file, changed in its values, lines or bytes, and shown."""
    lines = draw(of(SCENES)).splitlines()
    for _ in draw(several(3)):
        k = draw(st.integers(0, len(lines) - 1))
        turn = draw(st.integers(0, 9))
        if turn < 7:
            lines[k] = f"{lines[k].partition('=')[0]} = {draw(of(values.TOML))}"
        elif turn < 9:
            lines.insert(k, f"{draw(of(WORDS))} = {draw(of(values.TOML))}")
        else:
            lines[k] = draw(of(("", *HEADS)))
    text = draw(sometimes_mangled("\n".join(lines).encode()))
    return Case("", {"case.toml": text}, ["show", "case.toml"])


#: TOML at its limits, of a size n.
LIMITS: list[Callable[[int], str]] = [
    lambda n: "x = " + "[" * n,
    lambda n: "x = " + "[" * n + "]" * n,
    lambda n: "x = " + "{a=" * n + "1" + "}" * n,
    lambda n: ".".join(["a"] * n) + " = 1",
    lambda n: "[" + ".".join(["a"] * n) + "]",
    lambda n: "\n".join(f"[t{k}]" for k in range(n)),
    lambda n: "\n".join("[[events]]" for _ in range(n)),
    lambda n: "\n".join(f'[[events]]\nname = "e{k}"\nzero = "p"' for k in range(min(n, 3000))),
    lambda n: "\n".join(f"k{k} = 1" for k in range(n)),
    lambda n: 'title = "' + "\\u202e" * n + '"',
    lambda n: 'title = """' + "\n" * n + '"""',
    lambda n: "[run]\nat = [" + ",".join(map(str, range(n))) + "]",
    lambda n: "[run]\nsamples = " + "9" * min(n, 4000),
    lambda n: "[run]\nend = " + "1" * min(n, 9000) + ".5",
    lambda n: "[run]\nend = 1e" + "9" * min(n, 400),
    lambda n: '[run]\nend = "' + "(" * n + "1" + ")" * n + '"',
    lambda n: '[run]\nend = "' + "-" * n + '1"',
    lambda n: '[run]\nend = "' + "2**" * min(n, 300) + '2"',
    lambda n: '[run]\nend = "' + "sqrt(" * min(n, 300) + "2" + ")" * min(n, 300) + '"',
    lambda n: "[run]\noutputs = [" + ",".join(['"angles"'] * n) + "]",
    lambda n: "[expect]\n" + "\n".join(f"x{k} = [1, 2]" for k in range(n)),
    lambda n: "[[body.parts]]\n" * min(n, 1000),
    lambda n: "#" * n + "\nx = 1",
    lambda n: "\ufeff" * min(n, 10) + "x = 1",
    lambda n: "x = 1\r" * n,
    lambda n: "x = 2026-11-23T00:00:00." + "9" * n + "Z",
    lambda n: "x = 0x" + "f" * n,
]


@st.composite
def toml(draw: st.DrawFn) -> Case:
    """TOML at its limits: depth, keys, tables, strings, escapes, dates, numbers, duplicates."""
    text = draw(of(LIMITS))(draw(of((1, 10, 100, 1000, 5000, 30_000))))
    whole = draw(of((f"{text}\n{FREE}", f"{FREE}\n{text}")))
    return Case(text[:80], {"case.toml": whole.encode()}, ["show", "case.toml"])


@st.composite
def table(draw: st.DrawFn) -> Case:
    """A table, changed in its header, its cells, its width or its bytes, and judged."""
    header = ["t", "p", "q", "r", "gamma1", "gamma2", "gamma3"]
    rows = [["0", "0.3", "-0.4", "1.1", "0.6", "0", "0.8"]]
    rows += [["1", "0.3", "0.4", "1.1", "0", "0.6", "0.8"]]
    for _ in draw(several(3)):
        turn, k = draw(st.integers(0, 9)), draw(st.integers(0, len(header) - 1))
        row = draw(of((header, *rows)))
        if turn < 3:
            header[k] = draw(of(values.HEADERS))
        elif turn < 8 and row is not header:
            row[min(k, len(row) - 1)] = draw(of(values.CELLS))
        elif turn < 9:
            row += [draw(of(("", "x", "0")))] * draw(of((1, 1, 10, 10_000)))
        elif k:
            del row[k:]
    text = "\n".join(map(",".join, (header, *rows))).encode(errors="replace") + b"\n"
    words = draw(of((["compare", "case.csv", "top.toml"], ["frequencies", "case.csv"])))
    return Case("", {"case.csv": draw(sometimes_mangled(text))}, words)


#: A command of each verb that does little.
SMALL = {
    "list": "list --tag euler",
    "show": "show top.toml",
    "new": "new x.toml --cone 1,2,3",
    "run": "run top.toml --max-steps 300",
    "reference": "reference top.toml --at 1",
    "check": "check euler/rest",
    "compare": "compare table.csv top.toml",
    "sweep": "sweep top.toml --vary start.omega[3]=1,2 --workers 1 --max-steps 300",
    "plot": "plot top.toml --what angles -o x.svg",
    "view": "view top.toml -o x.html",
    "levels": "levels lagrange/nutation",
    "section": "section general/asymmetric-regular --grid 2x2 --crossings 2 --workers 1",
    "map": "map lagrange/nutation --grid 2x2 --end 5 --workers 1",
    "orbit": "orbit grioli/precession --digits 15",
    "prove": "prove orbit grioli/precession --digits 15",
    "verify": "verify top.toml",
    "frequencies": "frequencies top.toml --of p --end 50 --lines 1",
    "guide": "guide scene",
    "about": "about",
}


@st.composite
def command(draw: st.DrawFn) -> Case:
    """A command of any verb with one or two words that are wrong."""
    verb = draw(of(SMALL))
    words = SMALL[verb].split()
    if verb in ("compare", "frequencies", "plot", "show", "view") and draw(st.booleans()):
        words[1] = draw(of(("table.csv", "latin.csv", "euler/rest", "pendulum/rotating")))
    parser: Any = cli._parser(SMALL[verb].split()[:2])
    for name in (verb, "orbit"):  # the verb, and one of its verbs where it is a group
        if parser._subparsers is not None:
            parser = parser._subparsers._group_actions[0].choices[name]
    flags = {a.option_strings[-1]: a.nargs == 0 for a in parser._actions if a.option_strings}
    flags.pop("--help")
    for _ in draw(several(2)):
        flag, word = draw(of(flags)), draw(of(values.WORDS))
        if draw(st.integers(0, 4)) == 0 and len(words) > 1:
            words[1] = word
        elif flag in words:
            words[words.index(flag) + 1 - flags[flag]] = flag if flags[flag] else word
        else:
            words += [flag] if flags[flag] else [flag, word]
    return Case("", {}, words)


#: Arguments of a Scene that have a default.
SCENE: dict[str, Any] = {"name": "x", "title": "", "tags": (), "outputs": (), "reference": "auto"}
SCENE |= {"events": (), "published": (), "expect": {}, "source": "", "cite": ()}
BODY = [[[2, 0, 0], [0, 3, 0], [0, 0, 4]], [0, 0, 0], 0]
ROW = [0.3, -0.4, 1.1, 0.6, 0, 0.8]


def top() -> polhode.Scene:
    return polhode.load("top.toml")


#: Calls of the front door: what is called, its arguments in order and by name.
CALLS: dict[str, tuple[Callable[..., Any], list[Any], dict[str, Any]]] = {
    "load": (polhode.load, ["top.toml"], {}),
    "integrate": (
        polhode.integrate,
        ["top.toml"],
        {"at": [0], "digits": 10, "max_steps": 5, "project": None, "tol": None, "method": None},
    ),
    "reference": (polhode.reference, ["top.toml"], {}),
    "at": (lambda *a, **k: polhode.reference(top()).at(*a, **k), [[0]], {"digits": 10}),
    "angles": (lambda *a, **k: polhode.reference(top()).angles(*a, **k), [[0]], {"digits": 10}),
    "compare": (
        polhode.compare,
        [[ROW], "top.toml"],
        {"at": [0], "columns": None, "number": None},
    ),
    "integrate_many": (
        polhode.integrate_many,
        ["top.toml", {"start.omega[1]": [1]}],
        {"at": [0], "max_steps": 5, "workers": 1, "tol": None},
    ),
    "Body": (polhode.Body, BODY, {}),
    "of_moments": (polhode.Body.of_moments, [[2, 3, 4]], {"centre": [0, 0, 1], "weight": 1}),
    "Scene": (
        lambda *a, **k: polhode.Scene(polhode.Body(*BODY), *a, **k),
        [(1, 2, 3)],
        {"gamma": (0, 0, 1), "psi": 0, "times": (1,), "form": "principal", **SCENE},
    ),
    "Event": (  # what its words are worth shows in a scene that is run
        lambda **k: polhode.integrate(replace(top(), events=(polhode.Event(**k),)), at=[0]),
        [],
        {"name": "x", "zero": "p", "direction": "any", "stop": False},
    ),
    "rolling": (polhode.rolling, [None], {}),
    "compare_field": (
        polhode.compare_field,
        [lambda t, y: 0 * y, "top.toml"],
        {"variables": "omega"},
    ),
    "conditioning": (polhode.conditioning, ["top.toml", [0]], {"number": "double"}),
    "lyapunov": (polhode.lyapunov, ["top.toml"], {"end": 1, "max_steps": 10}),
    "trajectory": (lambda t: polhode.integrate(top(), at=[0])(t), [0], {}),
    "Scene.at": (lambda at: top().at(at), [[1]], {}),
}


@st.composite
def call(draw: st.DrawFn) -> Case:
    """A call of the front door with one or two arguments that are wrong."""
    name = draw(of(CALLS))
    function, arguments, named = CALLS[name]
    arguments = list(arguments)
    named = {k: v for k, v in named.items() if v is not None or draw(st.booleans())}
    for _ in draw(several(2)):
        wrong = draw(of(values.PYTHON))
        where = draw(of([*range(len(arguments)), *named]))
        (arguments if isinstance(where, int) else named)[where] = wrong
    said = f"{name}(*{arguments!r}, **{named!r})"
    return Case(said[:2000], {}, lambda: function(*arguments, **named))


def prepared(folder: Path) -> None:
    """The files that commands speak of, and no others."""
    for path in folder.iterdir():
        if path.is_file() or path.is_symlink():
            path.unlink()
    (folder / "folder/in").mkdir(parents=True, exist_ok=True)
    for name, text in FILES.items():
        (folder / name).write_bytes(text)
