"""Wide tables, TOML at its limits, films, and odd words for the verbs of a dynamical system."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import polhode
from polhode.dynamics.sections import jobs  # noqa: F401  (imported before memory is measured)

Work = Callable[[], Any]
Words = list[str]

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


GENERAL = "general/asymmetric-regular"

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
    "prove": ["--digits", "--period", "--returns", "--search", "--pick", "--h", "--f", "--orbit"],
    "frequencies": ["--of", "--end", "--lines", "-o"],
}
SMALL: dict[str, Words] = {
    "levels": [],
    "section": ["--grid", "2x2", "--crossings", "2"],
    "map": ["--grid", "2x2", "--end", "5"],
    "orbit": ["--digits", "15"],
    "prove": ["--digits", "15"],
    "frequencies": ["--of", "p", "--end", "50", "--lines", "1"],
}


def dynamic(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """A verb of the top as a dynamical system with one or two words that are wrong."""
    verb = random.choice([*DYNAMIC])
    where = random.choice(
        ("top.toml", GENERAL, "lagrange/nutation", "pendulum/rotating", "euler/sphere")
    )
    words = [verb, *["orbit"][: verb == "prove"], where, *SMALL[verb]]
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
    kind = random.choice((*(".html", ".svg", ".png") * 4, ".gif"))  # a film takes some seconds
    what = "motion" if kind in (".gif", ".html") else random.choice(("angles", "omega", "sphere"))
    end = random.choice(("0", "1e-300", "1e-9", "0.5", "1", "-1", "1e300", "nan", "1/0", "1e9"))
    where = random.choice(("top.toml", "lagrange/nutation", "euler/sphere", "pendulum/rotating"))
    name = f"folder/in/film{kind}"
    Path(name).unlink(missing_ok=True)
    words = ["plot", where, "--what", what, "--end", end, "-o", name]
    return repr(words), words
