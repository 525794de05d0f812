"""``polhode levels``: the diagram of energy and area, and where a scene lies in it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.numbers import expression
from polhode.numbers.conversion import to_double
from polhode.numbers.expression import ExpressionError
from polhode.scenes import library
from polhode.verbs.terminal import DONE, print_json, print_table, say, word

if TYPE_CHECKING:
    from polhode.dynamics.levels.levels import Levels

HELP = "the (f, h) diagram in closed form: permanent rotations, cusps, regions, where a scene lies"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    for key in ("f", "h"):
        parser.add_argument(f"--{key}", metavar="A:B", help=f"the range of {key} in a figure")
    parser.add_argument(
        "-o",
        dest="file",
        type=word,
        metavar="FILE",
        help="a figure, .svg, .png or .pdf; or arrays, .npz",
    )


def main(options: Namespace) -> int:
    """Print the special points and the scene's level; draw the diagram."""
    from polhode.dynamics.levels.levels import levels
    from polhode.figures.canvas import canvas
    from polhode.output import levels as output
    from polhode.verbs.answer_file import ARRAYS, answer_file

    scene = library.load(options.scene)
    ranges = [
        None if text is None else _range(scene.name, f"--{key}", text)
        for key, text in (("f", options.f), ("h", options.h))
    ]
    kinds, inputs = (*canvas.SUFFIXES, ARRAYS), [library.path_of(options.scene)]
    file = answer_file(options.file, kinds, inputs, options.json)
    found = levels(scene)
    if file is not None and file.holds_arrays:
        file.save(output.arrays(found))
    elif file is not None:
        f_range, h_range = ranges
        file.draw(found, scene.name, f_range=f_range, h_range=h_range)
    if options.json:
        print_json(output.of_levels(found))
    elif file is None or not file.on_stdout:
        _say(found)
    return DONE


def _say(found: Levels) -> None:
    from polhode.dynamics.levels.levels import topology
    from polhode.numbers.decimals import shown

    rows = [
        [mark.kind, mark.family, *(f"{float(x):.12g}" for x in (mark.parameter, mark.f, mark.h))]
        for mark in found.marks
    ]
    if rows:
        print_table(["special point", "family", "s or om", "f", "h"], rows)
    rows = [
        [
            curve.family + ("" if curve.axis is None else f" (axis {curve.axis + 1})"),
            curve.type + (", Liapunov stable" if curve.morse == 0 else ""),
            *("inf" if x is None else f"{float(x):.6g}" for x in (curve.first, curve.last)),
        ]
        for curve in found.curves
    ]
    for row in rows:
        row[2] = "-inf" if row[2] == "inf" else row[2]
    print_table(["permanent rotations", "type", "from s or om", "to"], rows)
    here = found.here
    edges = "" if here.region is None else f": edges {', '.join(map(str, here.region))}"
    say(f"scene  f = {shown(here.f)}, h = {shown(here.h)}, least h at this f {here.least:.12g}")
    say(f"level  {topology(here.region)}{edges}{here.remark and f' ({here.remark})'}")
    if here.fourth is not None:
        say(f"fourth integral  {here.fourth.name} = {here.fourth.value:.12g}; critical:")
        for value in here.fourth.critical:
            say(f"  {value.value:<20.12g}{value.what}")
    if not found.exact:
        say("decided with the irrational numbers of the body, or h and f, rounded to 1024 bits")


_LARGEST = 1e306  # of what an axis shows


def _range(name: str, key: str, text: str) -> tuple[float, float]:
    try:
        first, last = (to_double(expression.number(part)) for part in text.split(":"))
    except (ExpressionError, ValueError):
        raise BadInput(name, key, text, "A:B, two numbers") from None
    if max(abs(first), abs(last)) > _LARGEST:
        raise BadInput(name, key, text, f"A:B, two numbers of at most {_LARGEST:g}")
    if not first < last:
        raise BadInput(name, key, text, "A:B with A below B")
    return first, last
