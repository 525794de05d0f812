"""Cases made from a seed: scene files, options, tables and calls, right ones gone wrong."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import polhode
from fuzz import hostile_values as values

#: Right scenes, as tables of TOML text.
SCENES: list[dict[str, dict[str, str]]] = [
    {
        "": {"schema": "1", "title": '"a free body"', "tags": '["x"]', "cite": '["y"]'},
        "body": {"moments": "[2, 3, 4]"},
        "start": {"omega": "[0.3, -0.4, 1.1]", "gamma": "[0.6, 0, 0.8]", "psi": '"1/3"'},
        "run": {"end": "1", "samples": "3"},
        "expect": {"double": "[12, 17]"},
    },
    {
        "": {"schema": "1"},
        "body": {"moments": "[1, 1, 0.5]", "centre": "[0, 0, 1]", "weight": "1"},
        "start": {"angles": '["1/3", 1, 0]', "rates": "[0.1, 0, 3]"},
        "run": {"at": "[0, 1]", "outputs": '["angles"]'},
        "reference": {"kind": '"lagrange"'},
    },
    {
        "": {"schema": "1"},
        "body": {
            "inertia": "[[2, 0, 0], [0, 2, 0], [0, 0, 1]]",
            "centre": "[1, 0, 0]",
            "weight": "1",
        },
        "start": {"momentum": "[0.3, 0.2, 1.1]", "gamma": "[3, 0, 4]", "normalise": "true"},
        "run": {"at": "[1]", "form": '"quaternion"'},
        "[events]": {
            "name": '"x"',
            "zero": '"p - gamma1/2"',
            "direction": '"rising"',
            "stop": "true",
        },
        "[published]": {"t": "1", "quantity": '"p"', "value": '"0.1"', "cite": '"z"', "right": "1"},
    },
    {
        "": {"schema": "1"},
        "body": {
            "inertia": "[[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]]",
            "centre": "[1, 2, 3]",
            "weight": "0.1",
        },
        "start": {"omega": '["1/3", "sqrt(2)", 0]', "gamma": '["sin(1)", "cos(1)", 0]'},
        "run": {"end": "-2"},
    },
]
SECTIONS = (
    "",
    "body",
    "start",
    "run",
    "reference",
    "expect",
    "[events]",
    "[published]",
    "x",
    "body.x",
)
KEYS = sorted(
    {key for scene in SCENES for table in scene.values() for key in table} | {"x", '"a b"', "end"}
)

Case = Callable[[], list[str]]


def toml(scene: dict[str, dict[str, str]]) -> str:
    """A scene's text."""
    lines = []
    for section, table in scene.items():
        if section:
            lines.append(f"[{section}]")
        lines += [f"{key} = {value}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


def scene_file(random: Random) -> bytes:
    """A scene file, changed in its keys and values, or in its bytes."""
    scene = copy.deepcopy(random.choice(SCENES))
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        section = random.choice([*scene])
        table, turn = scene[section], random.random()
        if turn < 0.7 and table:
            table[random.choice([*table])] = random.choice(values.TOML)
        elif turn < 0.8 and table:
            del table[random.choice([*table])]
        elif turn < 0.9:
            table[random.choice(KEYS)] = random.choice(values.TOML)
        elif turn < 0.95:
            scene[random.choice(SECTIONS)] = {random.choice(KEYS): random.choice(values.TOML)}
        elif len(scene) > 1:
            del scene[section]
    return mangled(random, toml(scene).encode()) if random.random() < 0.3 else toml(scene).encode()


def mangled(random: Random, text: bytes) -> bytes:
    """Bytes changed, left out, doubled, put in."""
    held = bytearray(text)
    for _ in range(random.choice((1, 1, 2, 5))):
        at = random.randrange(len(held) + 1)
        turn = random.randrange(6)
        if turn == 0:
            held[at : at + 1] = bytes([random.randrange(256)])
        elif turn == 1:
            del held[at : at + random.choice((1, 3, 40))]
        elif turn == 2:
            held[at:at] = held[at : at + 40]
        elif turn == 3:
            held[at:at] = random.choice(
                [b"\r", b"\r\n", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b'"""', b"'"]
            )
        elif turn == 4:
            held[at:at] = random.choice(
                [b"[", b"]", b"{", b"}", b"=", b",", b"#", b".", b'"', b"\\", b"-"]
            )
        else:
            held[:] = held[:at]
    return bytes(held)


def table_file(random: Random) -> bytes:
    """A table, changed in its header, its cells, or its bytes."""
    header = ["t", "p", "q", "r", "gamma1", "gamma2", "gamma3"]
    rows = [
        ["0", "0.3", "-0.4", "1.1", "0.6", "0", "0.8"],
        ["1", "0.3", "0.4", "1.1", "0", "0.6", "0.8"],
    ]
    for _ in range(random.choice((1, 1, 2, 3))):
        turn, k = random.random(), random.randrange(len(header))
        if turn < 0.25:
            header[k] = random.choice(values.HEADERS)
        elif turn < 0.75:
            row = random.choice(rows)
            row[min(k, len(row) - 1)] = random.choice(values.CELLS)
        elif turn < 0.85:
            row = random.choice([header, *rows])
            del row[random.randrange(len(row)) :]
            row += ["0"] * (not row)
            if row is header:
                break
        else:
            rows.append([random.choice(values.CELLS)] * random.choice((1, len(header))))
    text = "\n".join(",".join(row) for row in (header, *rows)).encode(errors="replace") + b"\n"
    return mangled(random, text) if random.random() < 0.3 else text


#: Arguments of a Scene that have a default.
SCENE: dict[str, Any] = {"name": "x", "title": "", "tags": (), "outputs": (), "reference": "auto"}
SCENE |= {"events": (), "published": (), "expect": {}, "source": "", "cite": ()}

FLAGS: dict[str, list[str]] = {
    "run": [
        *("--digits", "--number", "--at", "--tol", "--form", "--outputs", "--max-steps"),
        *("--no-project", "--project-every", "-o", "--json", "--no-such"),
    ],
    "reference": ["--at", "--digits", "--json"],
    "show": ["--json"],
    "compare": ["--number", "--digits", "--json"],
    "sweep": [
        "--vary",
        "--digits",
        "--number",
        "--at",
        "--tol",
        "--max-steps",
        "--workers",
        "-o",
        "--json",
    ],
    "plot": ["--what", "-o", "--end", "--scene", "--number", "--digits"],
    "study": ["--quick", "-o"],
    "list": ["--tag"],
    "about": ["--json"],
    "nothing": [],
}
ALONE = {"--no-project", "--json", "--quick"}


def command(random: Random) -> list[str]:
    """A command line with at least one word that is wrong; it does little where it is right."""
    verb = random.choice([*FLAGS])
    words = [verb]
    if verb in ("run", "reference", "show", "sweep", "plot", "compare", "study"):
        words.append(
            random.choice(["top.toml", *values.WORDS]) if random.random() < 0.6 else "top.toml"
        )
    if verb == "compare":
        words.append("top.toml" if random.random() < 0.6 else random.choice(values.WORDS))
    if verb == "study":  # a study takes minutes: never a right one
        words[1] = random.choice([w for w in values.WORDS if w not in ("-", "--")])
    if verb == "plot":
        words += [
            "--what",
            random.choice(["angles", "integrals", "x"]),
            "-o",
            random.choice(values.WORDS),
        ]
    if verb == "sweep":
        words += ["--vary", random.choice(values.WORDS)]
    for _ in range(random.choice((0, 1, 1, 2))):
        flag = random.choice(FLAGS[verb] or ["--x"])
        words += [flag] if flag in ALONE else [flag, random.choice(values.WORDS)]
    return words


def call(random: Random, scene: polhode.Scene) -> tuple[str, Callable[[], Any]]:
    """A call of the front door with one or two arguments that are wrong, and how it is written."""
    import numpy as np

    from polhode.numbers.mpmath_context import mpf

    hostile = values.python(np.array, mpf)
    good: dict[str, tuple[list[Any], dict[str, Any]]] = {
        "load": ([scene], {}),
        "integrate": (
            [scene],
            {"at": [0], "digits": 10, "max_steps": 5, "project": None, "tol": None, "method": None},
        ),
        "reference": ([scene], {}),
        "reference.at": ([[0]], {"digits": 10}),
        "reference.angles": ([[0]], {"digits": 10}),
        "compare": (
            [[[0.3, -0.4, 1.1, 0.6, 0, 0.8]], scene],
            {"at": [0], "columns": None, "number": None},
        ),
        "integrate_many": (
            [scene, {"x": [1]}],
            {"at": [0], "max_steps": 5, "workers": 1, "tol": None},
        ),
        "Body": ([[[2, 0, 0], [0, 3, 0], [0, 0, 4]], [0, 0, 0], 0], {}),
        "Body.of_moments": ([[2, 3, 4]], {"centre": [0, 0, 1], "weight": 1}),
        "Scene": (
            [scene.body, (1, 2, 3)],
            {"gamma": (0, 0, 1), "psi": 0, "times": (1,), "form": "principal", **SCENE},
        ),
        "Event": ([], {"name": "x", "zero": "p", "direction": "any", "stop": False}),
        "rolling": ([None], {}),
        "conditioning": ([scene, [0]], {"number": "double", "max_steps": 10}),
        "lyapunov": ([scene], {"end": 1, "max_steps": 10}),
        "trajectory": ([0], {}),
        "Scene.at": ([[1]], {}),
    }
    name = random.choice([*good])
    given, named = good[name]
    named = {k: v for k, v in named.items() if v is not None or random.random() < 0.3}
    for _ in range(random.choice((1, 1, 2))):
        if named and (not given or random.random() < 0.6):
            named[random.choice([*named])] = random.choice(hostile)
        else:
            given[random.randrange(len(given))] = random.choice(hostile)
    asked = _ask(name, scene)
    return f"{name}(*{given!r}, **{named!r})", lambda: asked(*given, **named)


def _ask(name: str, scene: polhode.Scene) -> Callable[..., Any]:
    if name.startswith("reference."):
        return lambda *a, **k: getattr(polhode.reference(scene), name.partition(".")[2])(*a, **k)
    if name == "Event":  # what its words are worth shows in a scene that is run
        return lambda **k: _watched(scene, k)
    if name == "trajectory":
        return lambda *a: polhode.integrate(scene, at=[0])(*a)
    if name == "Scene.at":
        return scene.at
    if name == "Body.of_moments":
        return polhode.Body.of_moments
    return getattr(polhode, name)  # type: ignore[no-any-return]


def _watched(scene: polhode.Scene, event: dict[str, Any]) -> Any:
    """A run to t = 0 of a scene with one event."""
    return polhode.integrate(replace(scene, events=(polhode.Event(**event),)), at=[0])


def prepared(folder: Path) -> None:
    """The files that commands speak of."""
    (folder / "top.toml").write_text(toml(SCENES[0]))
    (folder / "table.csv").write_text("t,p,q,r\n0,0.3,-0.4,1.1\n")
    (folder / "latin.csv").write_bytes(b"t,p\n0,\xe9\n")
    (folder / "folder").mkdir(exist_ok=True)
