"""``polhode section``: where orbits of one level cross a section."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from collections import Counter
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput
from polhode.scenes import library
from polhode.verbs.terminal import (
    DONE,
    NOT_REACHED,
    ProgressLine,
    goes_on,
    note,
    positive,
    print_json,
    print_table,
    word,
)

HELP = "crossings of a section by many orbits on one level of energy and area"
_OUTPUT = "FILE.npz, or a figure .svg, .png, .pdf; an interrupted run continues from FILE.parts"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    by = "momentum (extrema of |G|, the default), height (of the centre), or an expression"
    parser.add_argument("--by", help=by)
    parser.add_argument("--extremum", help="max (default) or min")
    parser.add_argument("--grid", metavar="NxM", help="starts in the centres of N x M cells (9x8)")
    starts = (
        "a text file of starts, one a line: l L/G [k], or gamma1 gamma2 gamma3 ±1 for height; "
        "or the word scene, for the scene's own start"
    )
    parser.add_argument("--starts", type=word, metavar="FILE", help=starts)
    parser.add_argument("--crossings", type=positive, metavar="N", help="per orbit (500)")
    parser.add_argument(
        "--workers", type=positive, metavar="N", help="processes (as many as are useful)"
    )
    level_options(parser)


def level_options(parser: ArgumentParser, output: str = _OUTPUT) -> None:
    """The level, and the file of what is found on it, of the kinds that ``output`` tells."""
    for key in ("h", "f"):
        parser.add_argument(f"--{key}", metavar="X", help=f"{key} of the level, if not the scene's")
    parser.add_argument("-o", dest="file", type=word, metavar="FILE", help=output)


def main(options: Namespace) -> int:
    """Follow the orbits, print or write their crossings."""
    from polhode.common import checkpoint
    from polhode.dynamics.sections.section import section
    from polhode.dynamics.sections.starts import OWN, read_starts
    from polhode.figures.canvas import canvas
    from polhode.output import sections as output
    from polhode.verbs.answer_file import ARRAYS, answer_file

    scene = library.load(options.scene)
    grid = None if options.grid is None else read_grid(scene.name, options.grid)
    if grid is not None and options.starts is not None:
        raise BadInput(scene.name, "--starts", options.starts, "either --grid or --starts")
    kinds, inputs = (ARRAYS, *canvas.SUFFIXES), [library.path_of(options.scene)]
    file = answer_file(options.file, kinds, inputs, options.json)
    given: Any = options.starts
    if given not in (None, OWN):
        given = read_starts(Path(given))
    with ProgressLine("section") as progress:
        found = section(
            scene,
            options.by,
            options.extremum,
            given,
            grid,
            options.crossings,
            options.h,
            options.f,
            options.workers,
            parts=None if file is None else checkpoint.beside(file.path),
            progress=lambda fraction, done: progress.say(f"{100 * fraction:.0f} %, {done} orbits"),
        )
    if file is not None and not found.interrupted:
        if file.holds_arrays:
            file.save(output.arrays(found))
        else:
            file.draw(found, scene.name)
        if found.kept is not None:
            found.kept.remove()
    if options.json:
        print_json(output.of_section(found))
    elif file is None:
        print_table(*table(found))
    elif file.on_stdout:
        return DONE
    told = Counter(found.outcomes)
    note(f"{scene.name}: {found!r}; " + ", ".join(f"{name} in {n}" for name, n in told.items()))
    if not found.interrupted and (file is None or file.holds_arrays):
        note(f"{scene.name}: {lost(found)}")
    if found.interrupted:
        return goes_on(found.kept)
    return DONE if found.complete else NOT_REACHED


def read_grid(name: str, text: str) -> tuple[int, int]:
    """The two numbers of ``NxM``."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip())
    if match is None or int(match[1]) * int(match[2]) == 0:
        raise BadInput(name, "--grid", text, "NxM, such as 9x8")
    return int(match[1]), int(match[2])


def table(found: Any) -> tuple[list[str], list[list[str]]]:
    """Header and a line for each crossing."""
    rows = []
    for orbit, n in enumerate(found.counts):
        for m in range(n):
            numbers = (found.times[orbit, m], found.l[orbit, m], found.ratio[orbit, m])
            right = found.digits[orbit, m]
            digits = "-" if right != right else f"{right:.1f}"
            rows.append([str(orbit + 1), str(m + 1), *(f"{x:#.15g}" for x in numbers), digits])
    return ["orbit", "crossing", "t", "l", "L/G", "digits"], rows


def lost(found: Any) -> str:
    """In how many orbits no digit is left at the end, and from which crossing on."""
    first = found.none_left_from
    if not found.counts.any():
        return "no crossing"
    if not first.any():
        import numpy as np

        least = float(np.nanmin(found.digits))
        return f"{least:.1f} digits or more are expected at every crossing"
    gone = sorted(first[first > 0].tolist())
    where = f"{gone[0]}" if gone[0] == gone[-1] else f"{gone[0]} to {gone[-1]}"
    return f"no digits are left from crossing {where} on in {len(gone)} of {len(first)} orbits"
