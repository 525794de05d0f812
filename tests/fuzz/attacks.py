"""Cases of further classes, made from a seed: archives and kept parts that somebody changed, events
at double roots and at both ends, bodies and units at extremes, wide tables, TOML at its limits,
films, and the verbs of a top as a dynamical system.

Each maker changes what it must in the present folder and gives how the case is written and the
work, for :mod:`fuzz.promise`: an exit code for a command, anything for a call.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import polhode
from fuzz import hostile_values as values
from fuzz.generate import mangled
from polhode import cli
from polhode.dynamics.sections import jobs  # noqa: F401  (imported before memory is measured)
from polhode.runs.sweep import sweep_checkpoint
from polhode.scenes.shapes import SHAPES

Work = Callable[[], Any]
Words = list[str]

# -- archives -------------------------------------------------------------------------------------


def archive(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A saved run, changed in its arrays, its JSON or its bytes, loaded and asked."""
    saved = Path("folder/in/run.npz")
    if not saved.exists():
        watched = replace(scene, events=(polhode.Event("nutation"),), outputs=("angles",))
        polhode.integrate(watched, at=[0, "0.5", 1]).save(saved)
    with np.load(saved) as file:
        held = {name: file[name] for name in file.files}
    told = []
    for _ in range(random.choice((1, 1, 2))):
        turn, name = random.random(), random.choice([*held])
        if turn < 0.35:
            about = json.loads(str(held["about"]))
            key, value = random.choice([*about]), random.choice(values.JSON)
            about[key] = value
            held["about"] = np.array(json.dumps(about))
            told.append(f"about.{key} = {value!r}")
        elif turn < 0.5:
            held["about"] = np.array(str(held["about"]).replace(*random.choice(values.TEXTS)))
            told.append("text of about")
        elif turn < 0.7:
            held[name] = random.choice(values.arrays(held[name]))
            told.append(f"{name}: {held[name].dtype} {held[name].shape}")
        elif turn < 0.8:
            del held[name]
            told.append(f"without {name}")
            break
        else:
            cells = held[name].ravel().astype(object)
            if cells.size:
                cells[random.randrange(cells.size)] = random.choice(values.CELLS)
            held[name] = np.array(cells.astype(str)).reshape(held[name].shape)
            told.append(f"a cell of {name}")
    out = io.BytesIO()
    np.savez(out, **held)
    text = mangled(random, out.getvalue()) if random.random() < 0.2 else out.getvalue()
    Path("folder/in/changed.npz").write_bytes(text)

    def load() -> None:
        found = polhode.load_run("folder/in/changed.npz")
        _ = repr(found), found.drift, found.expected, found.state_strings(), found.time_strings()
        found("0.25")

    return "; ".join(told), load


# -- events ---------------------------------------------------------------------------------------

#: Zeros that touch, that lie at the start or at the end, that pile up, that are none.
ZEROS = [
    *("t", "t-1", "t*t", "(t-1)*(t-1)", "t*(t-1)", "(t-0.5)**2", "(t-0.5)**3", "t-0.5", "1-t"),
    *("(t-0.5)**2-1e-30", "(t-0.5)**2+1e-30", "(t-0.5)**2-1e-12", "(t-0.5)*(t-0.5000000001)"),
    *(
        "p-0.3",
        "(p-0.3)**2",
        "q+0.4",
        "r-1.1",
        "gamma1-0.6",
        "(gamma3-0.8)**2",
        "gamma2",
        "gamma2**2",
    ),
    *("sin(1000*t)", "sin(t)", "cos(1e6*t)", "sin(3.14159265358979*t)", "sin(t)**2", "t**20"),
    *(
        "(t-1/3)**2*(t-2/3)**2",
        "1e300*(t-0.5)",
        "1e-300*(t-0.5)",
        "t-1e-300",
        "t+1e-300",
        "t-1e300",
    ),
    *(
        "sqrt(t)",
        "sqrt(1-t)",
        "1/(t-2)",
        "1/t",
        "1/(t-0.5)**2",
        "sqrt((t-0.5)**2)",
        "t-t+1",
        "p-p+1",
    ),
    *(
        "gamma1**2+gamma2**2+gamma3**2-1.0000001",
        "p*q*r",
        "p*gamma1+q*gamma2",
        "t-0.9999999999999999",
    ),
]


def event(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A run with hostile events, either direction in time; its times are looked at."""
    zeros = [random.choice(ZEROS) for _ in range(random.choice((1, 1, 2, 3)))]
    ways = [random.choice(("any", "rising", "falling")) for _ in zeros]
    stops = [random.random() < 0.2 for _ in zeros]
    events = tuple(
        polhode.Event(f"e{k}", *told) for k, told in enumerate(zip(zeros, ways, stops, strict=True))
    )
    number = random.choice(("double", "double", "double", "extended", "quad"))
    end = random.choice((1, 1, -1, 2, "0.5", "1e-3"))
    text = f"{number} to {end}: {zeros} {ways} {stops}"

    def run() -> None:
        found = polhode.integrate(replace(scene, events=events), number, at=[0, end], max_steps=500)
        for one in found.events:
            sizes = [abs(t) for t in one.times]
            assert sizes == sorted(sizes), f"events out of order: {sizes}"
            assert all(0 <= t <= abs(found.reached) for t in sizes), f"beyond the run: {sizes}"
            assert len(one.times) == len(one.states) == len(one.grazing)

    return text, run


def proof(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """Proven events of the same kinds, none of them identically zero."""
    zeros = [zero for zero in ZEROS if "1e" not in zero and "1000*" not in zero]
    chosen = random.choice(zeros)
    text = Path("top.toml").read_text()
    Path("folder/in/proof.toml").write_text(f'{text}[[events]]\nname = "x"\nzero = "{chosen}"\n')
    words = ["reference", "folder/in/proof.toml", "--certified", "--events", "--digits", "12"]
    return chosen, [*words, "--at", random.choice(("1", "0,1", "0.5")), "--max-seconds", "5"]


# -- kept parts -----------------------------------------------------------------------------------

GENERAL = "general/asymmetric-regular"
KEEPERS: dict[str, Words] = {
    "sweep": ["sweep", "top.toml", "--vary", "start.omega[3]=1:2:40", "--workers", "1"],
    "section": ["section", GENERAL, "--grid", "2x2", "--crossings", "3", "--workers", "1"],
    "map": ["map", "lagrange/nutation", "--grid", "2x2", "--end", "10", "--workers", "1"],
}


class JobCheckpoint:
    """A verb's finished pieces in the middle of its work, and what it gives undisturbed."""

    def __init__(self, verb: str) -> None:
        self.words = [*KEEPERS[verb], "-o", f"folder/in/{verb}.npz"]
        self.whole = Path(f"folder/in/{verb}.npz")
        self.store = Path(f"folder/in/{verb}.store")
        self.folder = Path(f"folder/in/{verb}.npz.parts")
        every, sweep_checkpoint.EVERY = sweep_checkpoint.EVERY, 0.0
        removed = sweep_checkpoint.SweepCheckpoint.remove
        try:
            sweep_checkpoint.SweepCheckpoint.remove = lambda kept: kept.release()  # type: ignore[method-assign]
            from polhode.common.checkpoint import Checkpoint

            below = Checkpoint.remove
            Checkpoint.remove = lambda kept: kept.release()  # type: ignore[method-assign]
            assert cli.main([*self.words, "--json"]) == 0
            Checkpoint.remove = below  # type: ignore[method-assign]
        finally:
            sweep_checkpoint.SweepCheckpoint.remove, sweep_checkpoint.EVERY = removed, every  # type: ignore[method-assign]
        self.folder.rename(self.store)
        self.right = self.said()

    def said(self) -> dict[str, Any]:
        """The arrays of the result, but for what tells of this run."""
        with np.load(self.whole, allow_pickle=False) as held:
            return {name: held[name].tolist() for name in held.files if name != "about"}


_KEPT: dict[tuple[Path, str], JobCheckpoint] = {}


def kept(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A verb that finds pieces of before, one of them changed, and ends as if undisturbed."""
    verb = random.choice([*KEEPERS])
    known = _KEPT.get((Path.cwd(), verb)) or _KEPT.setdefault(
        (Path.cwd(), verb), JobCheckpoint(verb)
    )
    shutil.rmtree(known.folder, ignore_errors=True)
    shutil.copytree(known.store, known.folder)
    known.whole.unlink(missing_ok=True)
    piece = random.choice(sorted(known.folder.iterdir()))
    turn = random.random()
    if turn < 0.3 or piece.suffix == ".json":
        piece.write_bytes(mangled(random, piece.read_bytes()))
        told = f"bytes of {piece.name}"
    elif turn < 0.5:
        other = random.choice(sorted(known.folder.glob("*-*.npz")))
        piece.write_bytes(other.read_bytes())
        told = f"{other.name} as {piece.name}"
    elif turn < 0.6:
        piece.unlink()
        told = f"without {piece.name}"
    else:
        with np.load(piece, allow_pickle=False) as file:
            held = {name: file[name] for name in file.files}
        name = random.choice([*held])
        held[name] = random.choice(values.arrays(held[name]))
        np.savez(piece, **held)
        told = f"{name} of {piece.name}: {held[name].dtype} {held[name].shape}"

    def again() -> None:
        manifest = (known.folder / "manifest.json").read_bytes()
        changed = manifest != (known.store / "manifest.json").read_bytes()
        code = cli.main([*known.words, "--json"])
        if code == 2 and changed:  # of another work: refused, and left as it is
            shutil.rmtree(known.folder)
            raise polhode.BadInput("parts", "parts", None, "of this work")
        assert code == 0, code
        assert known.said() == known.right, "another result"
        assert not known.folder.exists()

    return f"{verb}: {told}", again


# -- bodies and units -----------------------------------------------------------------------------

SIZES = [
    *("1e-300", "1e-150", "1e-30", "1e-9", "0", "1", "3/7", "pi", "1e9", "1e30", "1e150", "1e300")
]
SIZES += ["1e-4000", "1e4000", "-1", "sqrt(2)*1e-200", "nan", "1/0"]


def body(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A top of parts, lengths, masses, g and rates at extremes, shown and run a little."""
    wild = random.random() < 0.3
    unit = random.choice(SIZES[:12])

    def size() -> str:
        return random.choice(SIZES) if wild else f"{unit}*{random.choice(('1', '3', '1/7', '0.6'))}"

    parts_of = []
    for _ in range(random.choice((1, 1, 2))):
        given: dict[str, Any] = {"mass": size()}
        shape = random.choice([*SHAPES])
        for name in SHAPES[shape].needs:
            vector = name in ("size", "semi_axes")
            given[name] = [size() for _ in range(3)] if vector else size()
        if random.random() < 0.5:
            given["at"] = [size() for _ in range(3)]
        if random.random() < 0.05:
            given[random.choice(("radius", "height", "inner", "size", "mass"))] = size()
        parts_of.append((shape, given))
    start = {"angles": [0, "1/3", 0], "rates": [0, 0, size()]}
    more = {"g": size(), "end": size()}
    text = f"{parts_of} {start} {more}"

    def make() -> None:
        made = [polhode.Part(shape, **given) for shape, given in parts_of]
        top = polhode.top(parts=made, **start, **more)
        _ = repr(top), polhode.as_toml(top), top.regime if hasattr(top, "regime") else None
        polhode.integrate(top, max_steps=20)

    return text, make


def units(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A right scene whose lengths and times are scaled by enormous and tiny powers."""
    a, b = random.choice(range(-200, 201, 20)), random.choice(range(-80, 81, 8))
    moments = [
        f"{m}e{a}" for m in random.choice((["2", "3", "4"], ["1", "1", "0.5"], ["2", "2", "1"]))
    ]
    omega = [f"{w}e{b}" for w in ("0.3", "-0.4", "1.1")]
    weight = f"1e{a + 2 * b}"
    number = random.choice(("double", "extended", "quad"))
    text = f"{number}: moments {moments}, omega {omega}, weight {weight}"

    def run() -> None:
        body_of = polhode.Body.of_moments(moments, centre=[0, 0, 1], weight=weight)
        top = polhode.Scene(body_of, omega, ("0.6", 0, "0.8"), times=(f"1e{-b}",))
        found = polhode.integrate(top, number, max_steps=1000)
        plain = polhode.Scene(
            polhode.Body.of_moments(
                [m.partition("e")[0] for m in moments], centre=[0, 0, 1], weight=1
            ),
            ("0.3", "-0.4", "1.1"),
            ("0.6", 0, "0.8"),
            times=(1,),
        )
        right = polhode.integrate(plain, number, max_steps=1000)
        off = [
            abs(float(x) - float(y))
            for x, y in zip(found.states[0][3:], right.states[0][3:], strict=True)
        ]
        assert max(off) < 1e-13, f"gamma off by {max(off)}"

    return text, run


# -- tables, TOML ---------------------------------------------------------------------------------


def wide(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """A table of many columns or of one endless row."""
    count = random.choice((10, 1000, 10_000, 100_000, 1_000_000))
    names = ["t", "p", "q", "r", "gamma1", "gamma2", "gamma3"]
    row = ["0", "0.3", "-0.4", "1.1", "0.6", "0", "0.8"]
    turn = random.choice(("other names", "one name", "empty names", "cells", "header", "commas"))
    extra = {"one name": ["p"] * count, "empty names": [""] * count}
    header = names + extra.get(turn, [f"x{k}" for k in range(count)])
    cells = row + ["0"] * (len(header) - len(row))
    if turn == "cells":
        header = names
    if turn == "header":
        cells = row
    if turn == "commas":
        header, cells = names, row + [""] * count
    Path("folder/in/wide.csv").write_text(",".join(header) + "\n" + ",".join(cells) + "\n")
    verb = random.choice((["compare"], ["frequencies"]))
    words = [*verb, "folder/in/wide.csv"] + ["top.toml"] * (verb == ["compare"])
    return f"{turn} {count}", words


def toml(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """TOML at its limits: depth, keys, tables, strings, escapes, dates, numbers, duplicates."""
    n = random.choice((1, 10, 100, 1000, 5000, 30_000))
    made = random.choice(
        [
            lambda: "x = " + "[" * n,
            lambda: "x = " + "[" * n + "]" * n,
            lambda: "x = " + "{a=" * n + "1" + "}" * n,
            lambda: ".".join(["a"] * n) + " = 1",
            lambda: "[" + ".".join(["a"] * n) + "]",
            lambda: "\n".join(f"[t{k}]" for k in range(n)),
            lambda: "\n".join("[[events]]" for _ in range(n)),
            lambda: "\n".join(
                f'[[events]]\nname = "e{k}"\nzero = "p"' for k in range(min(n, 3000))
            ),
            lambda: "\n".join(f"k{k} = 1" for k in range(n)),
            lambda: 'title = "' + "\\u202e" * n + '"',
            lambda: 'title = """' + "\n" * n + '"""',
            lambda: "title = '''" + "x" * n + "'''",
            lambda: "[run]\nat = [" + ",".join(map(str, range(n))) + "]",
            lambda: "[run]\nsamples = " + "9" * min(n, 4000),
            lambda: "[run]\nend = " + "1" * min(n, 9000) + ".5",
            lambda: "[run]\nend = 1" + "e" * min(n, 3),
            lambda: "[run]\nend = 1e" + "9" * min(n, 400),
            lambda: '[run]\nend = "' + "(" * n + "1" + ")" * n + '"',
            lambda: '[run]\nend = "' + "-" * n + '1"',
            lambda: '[run]\nend = "' + "2**" * min(n, 300) + '2"',
            lambda: '[run]\nend = "' + "sqrt(" * min(n, 300) + "2" + ")" * min(n, 300) + '"',
            lambda: "[run]\noutputs = [" + ",".join(['"angles"'] * n) + "]",
            lambda: "[expect]\n" + "\n".join(f"x{k} = [1, 2]" for k in range(n)),
            lambda: "[[body.parts]]\n" * min(n, 1000),
            lambda: "#" * n + "\nx = 1",
            lambda: "\ufeff" * min(n, 10) + "x = 1",
            lambda: "x = 1\r" * n,
            lambda: "x = 2026-11-23T00:00:00." + "9" * n + "Z",
            lambda: "x = 0x" + "f" * n,
            lambda: '"' + "k" * n + '" = 1',
        ]
    )()
    right = Path("top.toml").read_text()
    text = made + "\n" + right if random.random() < 0.4 else right + "\n" + made
    Path("folder/in/limit.toml").write_text(text, encoding="utf-8", newline="")
    return made[:80], ["show", "folder/in/limit.toml"]


# -- the other verbs ------------------------------------------------------------------------------

ODD = [
    "",
    "0",
    "-1",
    "1e300",
    "1e-300",
    "nan",
    "inf",
    "x",
    "1:2",
    "2:1",
    "0:0",
    "1:1",
    "1e300:1e301",
]
ODD += [
    "2x2",
    "0x0",
    "1x1",
    "99999x99999",
    "2x",
    "p",
    "sqrt(q)",
    "1/q",
    "momentum",
    "height",
    "9" * 25,
]
DYNAMIC: dict[str, list[str]] = {
    "levels": ["--f", "--h", "-o"],
    "section": ["--by", "--grid", "--crossings", "--h", "--f", "--starts", "-o"],
    "map": ["--grid", "--end", "--tol", "--vary", "-o"],
    "orbit": ["--digits", "--period", "--returns", "--search", "--pick", "--continue"],
    "frequencies": ["--of", "--end", "--lines", "-o"],
}
SMALL: dict[str, Words] = {
    "levels": [],
    "section": ["--grid", "2x2", "--crossings", "2"],
    "map": ["--grid", "2x2", "--end", "5"],
    "orbit": ["--digits", "15"],
    "frequencies": ["--of", "p", "--end", "50", "--lines", "1"],
}


def dynamic(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """A verb of the top as a dynamical system with one or two words that are wrong."""
    verb = random.choice([*DYNAMIC])
    where = random.choice(
        ("top.toml", GENERAL, "lagrange/nutation", "pendulum/rotating", "euler/sphere")
    )
    words = [verb, where, *SMALL[verb]]
    for _ in range(random.choice((1, 1, 2))):
        flag = random.choice(DYNAMIC[verb])
        odd = random.choice(("folder", "folder/in/x.txt", "", "no/x.svg") if flag == "-o" else ODD)
        if flag in words:
            words[words.index(flag) + 1] = odd
        else:
            words += [flag, odd]
    return repr(words), words


def film(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """A figure, page or film to odd ends, of odd scenes."""
    kind = random.choice((".gif", ".html", ".svg", ".png"))
    what = "motion" if kind in (".gif", ".html") else random.choice(("angles", "omega", "sphere"))
    end = random.choice(("0", "1e-300", "1e-9", "0.5", "1", "-1", "1e300", "nan", "1/0", "1e9"))
    where = random.choice(("top.toml", "lagrange/nutation", "euler/sphere", "pendulum/rotating"))
    name = f"folder/in/film{kind}"
    Path(name).unlink(missing_ok=True)
    words = ["plot", where, "--what", what, "--end", end, "-o", name]
    return repr(words), words


#: How a class is made; a command where it gives words.
MAKERS: dict[str, Callable[[Random, polhode.Scene], tuple[str, Any]]] = {
    **{"archive": archive, "event": event, "proof": proof, "kept": kept, "body": body},
    **{"units": units, "wide": wide, "toml": toml, "dynamic": dynamic, "film": film},
}
