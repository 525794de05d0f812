"""The benchmark's folder: data, values and certificates of each top, checkers, and what it is."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

from polhode.benchmark.certified_values import COLUMNS, CertifiedValues, certified_values
from polhode.benchmark.tops import DIGITS, TOPS, VERSION, Top
from polhode.common.errors import BadInput, nearest
from polhode.common.files import make_folder, write_whole
from polhode.common.interrupts import Message
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact, binary, rounded
from polhode.scenes import library
from polhode.scenes.scene import Scene

DATA, PAGE = "tops.json", "README.md"
CHECKERS = ("check.py", "check.c", "check.js")
SECONDS = 7  # of the processor that a top takes, about
NAME = "heavy top benchmark"
_PLACES, _BITS = 60, 1000  # of decimals of data that have no end, and of what they are made from
_HERE = Path(__file__).parent / "checkers"


def write_benchmark(
    folder: Path, only: Iterable[str] = (), tick: Message | None = None
) -> list[Path]:
    """Write the benchmark, each top's files whole as they are proved; the paths.

    ``only``: names of tops, whose values and certificates alone are written.
    """
    chosen = [_named(name) for name in only] or [*TOPS]
    make_folder(folder)
    written: list[Path] = []
    found: dict[str, CertifiedValues] = {}
    for n, top in enumerate(chosen):
        if tick is not None:
            tick(f"{top.name}, {n + 1} of {len(chosen)}; about {SECONDS} s each")
        found[top.name] = values = certified_values(top)
        certificate = json.dumps(values.certificate()) + "\n"
        written += _save(folder, {f"{top.name}.csv": values.csv, _proof(top): certificate})
    if len(found) == len(TOPS):
        texts = {name: (_HERE / name).read_text(encoding="utf-8") for name in CHECKERS}
        written += _save(folder, texts | {DATA: data(found), PAGE: page()})
    return written


def _save(folder: Path, texts: dict[str, str]) -> list[Path]:
    files: dict[Path, str | bytes] = {folder / name: text for name, text in texts.items()}
    write_whole(files)
    return [*files]


def _proof(top: Top) -> str:
    return f"{top.name}.certificate.json"


def _named(name: str) -> Top:
    for top in TOPS:
        if name in (top.name, top.case):
            return top
    raise BadInput("benchmark", "--only", name, nearest(name, [top.name for top in TOPS]))


def data(found: dict[str, CertifiedValues]) -> str:
    """Exact data of all tops as JSON: the numbers of the scene's file, and all as decimals."""
    tops = []
    for top in TOPS:
        values = found[top.name]
        tops.append(
            {
                "name": top.name,
                "about": top.about,
                "case": top.case,
                "exact": _written(top.case),
                "decimal": _decimals(values.scene),
                "attitude": values.rows[0][6:],
                "times": values.times[1:],
                "places": {"omega": values.places[0], "gamma and attitude": values.places[1]},
                "values": f"{top.name}.csv",
                "certificate": _proof(top),
            }
        )
    return json.dumps({"name": NAME, "version": VERSION, "tops": tops}, indent=1) + "\n"


def _written(case: str) -> dict[str, object]:
    """Body and start as the scene's file has them, numbers as texts."""
    path = library.folder() / f"{case}.toml"
    told = tomllib.loads(path.read_text(encoding="utf-8"), parse_float=str)
    return {part: told[part] for part in ("body", "start")}


def _decimals(scene: Scene) -> dict[str, object]:
    body, gamma = scene.body, scene.gamma
    assert gamma is not None
    moments = [body.inertia[k][k] for k in range(3)]
    rows = {"moments": moments, "centre": body.centre, "omega": scene.omega, "gamma": gamma}
    decimals = {key: [_decimal(x) for x in row] for key, row in rows.items()}
    return {"weight": _decimal(body.weight), **decimals}


def _decimal(x: Exact) -> str:
    """In full where that is short, else to 60 digits."""
    near = x if isinstance(x, Fraction) else binary(*rounded(x, _BITS))
    text = decimal_string(near, _PLACES)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def page() -> str:
    """What the folder is, and how it is used, in Markdown."""
    rows = [
        f"| [{top.name}]({top.name}.csv) | {top.about} | {top.times[-1]} | [proof]({_proof(top)}) |"
        for top in TOPS
    ]
    text = (_HERE / "page.md").read_text(encoding="utf-8")
    return text.format(
        version=VERSION,
        count=len(TOPS),
        digits=DIGITS,
        columns=",".join(COLUMNS),
        rows="\n".join(rows),
    )
