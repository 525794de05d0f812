"""``polhode map``: which motions of a level, or of varied scenes, are chaotic."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput
from polhode.scenes import library
from polhode.verbs.section import read_grid
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    Progress,
    note,
    positive,
    print_json,
    refuse_two_on_stdout,
    say,
)

HELP = "a chaos map: growth of one tangent a motion, over a section's grid or two varied numbers"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--grid", metavar="NxM", help="cells of the section's coordinates (50x50)")
    vary = "a number of the scene file and N values for it, or KEY=a,b,c; two of them"
    parser.add_argument("--vary", metavar="KEY=FROM:TO:N", action="append", help=vary)
    parser.add_argument("--end", metavar="T", help="how far: 1000 radians or so unless given")
    parser.add_argument("--by", help="momentum (default) or height: see polhode section")
    parser.add_argument("--extremum", help="max (default) or min")
    for key in ("h", "f"):
        parser.add_argument(f"--{key}", metavar="X", help=f"{key} of the level, if not the scene's")
    parser.add_argument("--tol", metavar="X", help="tolerance of a step (1e-8)")
    what = "what a figure shows: fli (default), megno, exponent or verdict"
    parser.add_argument("--what", choices=("fli", "megno", "exponent", "verdict"), help=what)
    parser.add_argument("--workers", type=positive, metavar="N", help="threads (all cores)")
    output = "FILE.npz, or a figure .svg, .png, .pdf; what was stopped goes on from FILE.part"
    parser.add_argument("-o", dest="file", metavar="FILE", help=output)


def main(options: Namespace) -> int:
    """Follow the motions; print the counts, write the map."""
    from polhode.common.files import check_writable, is_stdout, write_whole
    from polhode.dynamics.chaos_maps import TOLERANCE, chaos_map
    from polhode.figures import canvas
    from polhode.output import maps as output
    from polhode.output import sections
    from polhode.scenes import vary

    scene = library.load(options.scene)
    grid = None if options.grid is None else read_grid(scene.name, options.grid)
    varied: dict[str, Any] | None = None
    if options.vary:
        varied = {}
        for text in options.vary:
            key, values = vary.option(text, scene.name)
            if key in varied:
                raise BadInput(scene.name, "--vary", text, f"{key} once")
            varied[key] = values
    path = None if options.file is None else Path(options.file)
    if path is not None:
        check_writable(path, [".npz", *canvas.SUFFIXES], [library.path_of(options.scene)])
        refuse_two_on_stdout(path, options.json)
        if path.suffix.lower() in canvas.SUFFIXES:
            canvas.require()
    with Progress("map") as progress:
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
            parts=None if path is None else sections.parts_of(path),
            progress=lambda fraction, done: progress.say(f"{100 * fraction:.0f} %, {done} motions"),
        )
    if path is not None and not found.interrupted:
        if path.suffix.lower() in canvas.SUFFIXES:
            from polhode.figures import map as figure

            shown = figure.Shown(found, options.what or "fli")
            title = f"polhode: map of {scene.name}"
            write_whole({path: canvas.drawn(figure.draw, shown, path.suffix.lower(), title)})
        else:
            sections.write_arrays(path, output.arrays(found))
        if found.kept is not None:
            found.kept.remove()
    if options.json:
        print_json(output.of_map(found))
    elif path is None or not is_stdout(path):
        for name, n in found.counts.items():
            say(f"{name:<10}{n:>8}  {100 * n / len(found.verdict):.1f} %")
    note(f"{scene.name}: {len(found.verdict)} motions, regular means up to t = {found.end:g}")
    if found.interrupted:
        if found.kept is not None:
            note(f"polhode: the same command goes on from {found.kept.folder}")
        return INTERRUPTED
    return DONE


def _tolerance(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise BadInput(name, "--tol", text, "a tolerance, such as 1e-8") from None
