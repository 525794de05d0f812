"""Right scenes, tables, commands and calls gone wrong, as strategies of hypothesis."""

import copy
import functools
import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import strategies as st

import polhode
from fuzz import values
from polhode import cli
from polhode.output import new_scene
from polhode.results.writer import beside
from polhode.runs.saved import Saved
from polhode.scenes import vocabulary
from polhode.scenes.shapes import SHAPES
from shared.motions import free_file
from shared.results import CERTIFIED, result_of_kind


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
    "compare": (polhode.compare, [[ROW], "top.toml"], {"at": [0], "columns": None, "number": None}),
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


# -- Events at double roots and at both ends, proven ones, bodies at extremes, as strategies -------

#: Zeros that touch, that lie at the start or at the end, that pile up, that are none.
ZEROS = (
    """
t; t-1; t*t; (t-1)*(t-1); t*(t-1); (t-0.5)**2; (t-0.5)**3; t-0.5; 1-t; t**20; (t-0.5)**2-1e-30
(t-0.5)**2+1e-30; (t-0.5)**2-1e-12; (t-0.5)*(t-0.5000000001); p-0.3; (p-0.3)**2; q+0.4; r-1.1
gamma1-0.6; (gamma3-0.8)**2; gamma2; gamma2**2; sin(1000*t); sin(t); cos(1e6*t); sin(t)**2
sin(3.14159265358979*t); (t-1/3)**2*(t-2/3)**2; 1e300*(t-0.5); 1e-300*(t-0.5); t-1e-300; t+1e-300
t-1e300; sqrt(t); sqrt(1-t); 1/(t-2); 1/t; 1/(t-0.5)**2; sqrt((t-0.5)**2); t-t+1; p-p+1; p*q*r
gamma1**2+gamma2**2+gamma3**2-1.0000001; p*gamma1+q*gamma2; t-0.9999999999999999
""".strip()
    .replace("\n", "; ")
    .split("; ")
)


@st.composite
def event(draw: st.DrawFn) -> Case:
    """A run with hostile events, either direction in time; its times are looked at."""
    ways = of(("any", "rising", "falling"))
    events = tuple(
        polhode.Event(f"e{k}", draw(of(ZEROS)), draw(ways), draw(st.integers(0, 4)) == 0)
        for k in draw(several(3))
    )
    number = draw(of(("double", "double", "double", "extended", "quad")))
    end = draw(of((1, 1, -1, 2, "0.5", "1e-3")))

    def run() -> None:
        scene = replace(top(), events=events)
        result = polhode.integrate(scene, number, at=[0, end], max_steps=500)
        for crossings in result.events:
            sizes = [abs(t) for t in crossings.times]
            assert sizes == sorted(sizes), f"events out of order: {sizes}"
            assert all(0 <= t <= abs(result.reached) for t in sizes), f"beyond the run: {sizes}"
            assert len(crossings.times) == len(crossings.states) == len(crossings.grazing)

    return Case(f"{number} to {end}: {events}", {}, run)


@st.composite
def proof(draw: st.DrawFn) -> Case:
    """Proven events of the same kinds, none of them identically zero."""
    zero = draw(of(z for z in ZEROS if "1e" not in z and "1000*" not in z))
    text = f'{FREE}[[events]]\nname = "x"\nzero = "{zero}"\n'
    words = ["certify", "case.toml", "--events", "--digits", "12"]
    words += ["--at", draw(of(("1", "0,1", "0.5"))), "--max-seconds", "5"]
    return Case(zero, {"case.toml": text.encode()}, words)


SIZES = ["1e-300", "1e-150", "1e-30", "1e-9", "0", "1", "3/7", "pi", "1e9", "1e30", "1e150"]
WILD = [*SIZES, "1e300", "1e-4000", "1e4000", "-1", "sqrt(2)*1e-200", "nan", "1/0"]


@st.composite
def body(draw: st.DrawFn) -> Case:
    """A top of parts, lengths, masses, g and rates at extremes, shown and run a little."""
    unit = draw(of(SIZES))
    sizes = draw(of((of(WILD), of(f"{unit}*{x}" for x in ("1", "3", "1/7", "0.6")))))
    three = st.lists(sizes, min_size=3, max_size=3)
    parts = []
    for _ in draw(several(2)):
        shape = draw(of(SHAPES))
        keys: dict[str, Any] = {"mass": draw(sizes)}
        for name in SHAPES[shape].needs:
            keys[name] = draw(three if name in ("size", "semi_axes") else sizes)
        if draw(st.booleans()):
            keys["at"] = draw(three)
        if draw(st.integers(0, 19)) == 0:
            keys[draw(of(("radius", "height", "inner", "size", "mass")))] = draw(sizes)
        parts.append((shape, keys))
    more = {"rates": [0, 0, draw(sizes)], "g": draw(sizes), "end": draw(sizes)}

    def make() -> None:
        solids = [polhode.Part(shape, **keys) for shape, keys in parts]
        scene = polhode.top(parts=solids, angles=[0, "1/3", 0], **more)
        _ = repr(scene), polhode.as_toml(scene)
        polhode.integrate(scene, max_steps=20)

    return Case(f"{parts} {more}", {}, make)


#: Moments, centre and weight hundreds of powers of ten apart.
RATIOS = {
    "a moment near zero": ('1, 1, "1e-300"', "0.1, 0, 1", "1"),
    "another one": ('1, "1e-300", 1', "0.1, 0, 1", "1"),
    "a heavy one": ('"1e300", "1e300", "1e-300"', "0.1, 0.2, 1", "1e300"),
    "small ones": ('"1e-300", "1e-300", "1e-300"', "0, 0, 1", "1"),
    "beyond doubles": ('"1e400", "1e400", "1e400"', '0.1, 0.2, "1e300"', "1e300"),
}
# -- valid scenes that are extreme -----------------------------------------------------------------

KINDS = ("euler", "lagrange", "kovalevskaya", "pendulum", "general")
GAMMAS = [
    (Fraction(3, 5), 0, Fraction(4, 5)),
    (Fraction(2, 7), Fraction(3, 7), Fraction(6, 7)),
    (0, Fraction(-5, 13), Fraction(12, 13)),
]


def powers(most: int) -> st.SearchStrategy[Fraction]:
    """Numbers of any size between 10**-most and 10**most."""
    return st.builds(
        lambda x, n: Fraction(x, 10) * Fraction(10) ** n,
        st.integers(1, 99),
        st.integers(-most, most),
    )


@st.composite
def extreme(draw: st.DrawFn, kind: str) -> polhode.Scene:
    """A scene of a kind of top that turns by about a radian."""
    size, hair = draw(powers(100)), Fraction(1, 10 ** draw(of((1, 8, 30))))
    weight, gamma = draw(powers(200)), draw(of(GAMMAS))
    omega = [draw(powers(3)) * draw(of((-1, 1))) for _ in range(3)]
    moments, centre = [Fraction(2), Fraction(3), 3 + hair], (1, 2, 3)
    if kind == "euler":
        moments, centre = draw(st.permutations([Fraction(1), 1 + hair / 3, hair])), (0, 0, 0)
        omega = draw(of((omega, [hair, 1, hair], [1, hair, 0])))
    elif kind == "lagrange":
        moments, centre = [Fraction(1), Fraction(1), draw(powers(6)) % 2 or 1], (0, 0, 1)
        omega = draw(of((omega, [hair, 0, 10 ** draw(st.integers(0, 8))])))
    elif kind == "kovalevskaya":
        moments, centre = [Fraction(2), Fraction(2), Fraction(1)], (1, 0, 0)
    elif kind == "pendulum":
        moments, centre = [Fraction(2), Fraction(3), Fraction(4)], (1, 0, 0)
        omega, gamma = [0, 0, omega[2]], (0, 1, 0)
    # the unit of time in which a weight of that size turns the body by about a radian
    torque = weight * (centre != (0, 0, 0))
    rate = _root(torque / (size * max(moments))) if torque else draw(powers(100))
    fastest = max(abs(w) for w in omega)
    omega = [Fraction(w) / fastest * rate * draw(of((1, 2))) for w in omega]
    heavy = polhode.Body.of_moments([size * m for m in moments], centre, torque)
    time = draw(of((1, -1))) / max(abs(w) for w in omega)
    return polhode.Scene(heavy, omega, gamma, times=(time,), name=kind)


def _root(x: Fraction) -> Fraction:
    """A power of ten near the root of a number: a rate of its size."""
    digits = len(str(x.numerator)) - len(str(x.denominator))
    return Fraction(10) ** (digits // 2)


# -- Files of polhode's own that somebody changed, as strategies: results and runs -----------------


@functools.cache
def saved(name: str, suffix: str) -> bytes:
    """The file in which a result of that kind is saved: of a CSV, the one beside it."""
    with tempfile.TemporaryDirectory() as folder:
        result_of_kind(name).save(path := Path(folder) / f"x{suffix}")
        return (beside(path) if suffix == ".csv" else path).read_bytes()


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path of each part of a JSON value."""
    keys = (
        value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    )
    return [at, *(place for key in keys for place in places(value[key], (*at, key)))]


@st.composite
def altered(draw: st.DrawFn, value: Any) -> Any:
    """A JSON value with one part changed, left out, or another one in its place."""
    document = {"": copy.deepcopy(value)}
    at, second = (("", *draw(of(places(value)))) for _ in range(2))
    parent = functools.reduce(lambda part, key: part[key], at[:-1], document)
    turn = draw(st.integers(0, 9))
    if turn < 7:
        parent[at[-1]] = copy.deepcopy(draw(of(values.JSON)))
    elif turn < 8 and len(at) > 1:
        del parent[at[-1]]
    else:
        part = functools.reduce(lambda part, key: part[key], second, document)
        parent[at[-1]] = copy.deepcopy(part)
    return document[""]


def use_result(name: str) -> None:
    """A result that can be loaded is a run or what it told, and answers."""
    result = polhode.load_result(name)
    assert isinstance(result, (polhode.Trajectory, Saved))
    assert repr(result)
    assert result == result
    if isinstance(result, polhode.Trajectory):
        _ = result.drift, result.expected, result.state_strings(), result.time_strings()
        result("0.25")
    else:
        assert result.to_json()


@st.composite
def result(draw: st.DrawFn, names: Sequence[str]) -> Case:
    """A saved result: a value of its JSON changed, or some bytes."""
    name, suffix = draw(of(names)), ".json"
    if draw(st.booleans()):
        document = draw(altered(json.loads(result_of_kind(name).to_json())))
        text = json.dumps(document).encode()
    else:
        suffix = draw(of((".csv", ".npz", ".json")[: 2 + (name not in CERTIFIED)]))
        text = draw(mangled(saved(name, suffix)))
    beside_it = {"x.csv": b"t\n0\n"} if suffix == ".csv" else {}
    files = {f"x{suffix}".replace(".csv", ".csv.json"): text} | beside_it
    return Case(name, files, lambda: use_result(f"x{suffix}"))
