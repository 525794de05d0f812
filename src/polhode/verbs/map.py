"""``polhode map``: which motions of a level, or of varied scenes, are chaotic."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput
from polhode.common.text_tables import counted
from polhode.scenes import library
from polhode.verbs.section import level_options, read_grid
from polhode.verbs.terminal import (
    DONE,
    ProgressLine,
    goes_on,
    note,
    positive,
    print_json,
    say,
    word,
)

HELP = "a chaos map: growth of one tangent per motion, over a section's grid or two varied numbers"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--grid", metavar="NxM", help="cells of the section's coordinates (50x50)")
    vary = "a number of the scene file and N values for it, or KEY=a,b,c; given twice"
    parser.add_argument("--vary", metavar="KEY=FROM:TO:N", action="append", help=vary)
    parser.add_argument("--end", metavar="T", help="last time (default: about 1000 radians)")
    parser.add_argument("--by", help="momentum (default) or height: see polhode section")
    parser.add_argument("--extremum", help="max (default) or min")
    parser.add_argument("--tol", metavar="X", help="tolerance of a step (1e-8)")
    what = "what a figure shows: fli (default), megno, exponent or verdict"
    parser.add_argument("--what", choices=("fli", "megno", "exponent", "verdict"), help=what)
    parser.add_argument("--workers", type=positive, metavar="N", help="threads (all cores)")
    level_options(parser)


def main(options: Namespace) -> int:
    """Follow the motions; print the counts, write the map."""
    from polhode.common import checkpoint
    from polhode.dynamics.chaos.chaos_map import TOLERANCE, chaos_map
    from polhode.figures.canvas import canvas
    from polhode.output import maps as output
    from polhode.scenes.variation import vary
    from polhode.verbs.answer_file import ARRAYS, answer_file

    scene = library.load(options.scene)
    grid = None if options.grid is None else read_grid(scene.name, options.grid)
    varied = vary.options(options.vary, scene.name, scene.units) if options.vary else None
    kinds, inputs = (ARRAYS, *canvas.SUFFIXES), [library.path_of(options.scene)]
    file = answer_file(options.file, kinds, inputs, options.json)
    with ProgressLine("map") as progress:
        found = chaos_map(
            scene,
            grid,
            varied,
            options.end,
            options.by,
            options.extremum,
            options.h,
            options.f,
            TOLERANCE if options.tol is None else _tolerance(scene.name, options.tol),
            options.workers,
            parts=None if file is None else checkpoint.beside(file.path),
            progress=lambda fraction, done: progress.say(f"{100 * fraction:.0f} %, {done} motions"),
        )
    if file is not None and not found.interrupted:
        if file.holds_arrays:
            file.save(output.arrays(found))
        else:
            file.draw(found, scene.name, options.what)
        if found.kept is not None:
            found.kept.remove()
    if options.json:
        print_json(output.of_map(found))
    elif file is None or not file.on_stdout:
        for name, n in found.counts.items():
            say(f"{name:<10}{n:>8}  {100 * n / len(found.verdict):.1f} %")
    note(f"{scene.name}: {counted(len(found.verdict), 'motion')}, {output.means(found)}")
    if found.interrupted:
        return goes_on(found.kept)
    return DONE


def _tolerance(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise BadInput(name, "--tol", text, "a tolerance, such as 1e-8") from None
