"""``polhode plot``: figures of a motion, from a scene or from a trajectory file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.numbers import expression
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.scenes import library
from polhode.scenes.words import ANGLES, ATTITUDE, SPACE, STATE
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    NOT_REACHED,
    Progress,
    note,
    print_json,
    refuse_two_on_stdout,
    say,
    whole,
)

if TYPE_CHECKING:
    from polhode.figures.samples import Samples
    from polhode.runs.trajectory import Trajectory

HELP = "a figure of a motion, from a scene or a trajectory file"
OVER_TIME = ("integrals", "error")  # of the whole run: not cut to a window
OUTPUTS = {"angles": ("angles",), "hodographs": ("attitude", "hodographs"), "sphere": ("attitude",)}
KINDS = (*OUTPUTS, *OVER_TIME)


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("what_of", metavar="SCENE|FILE", help="a case, a scene's path, or a CSV")
    parser.add_argument("--what", required=True, choices=KINDS, help="the kind of figure")
    parser.add_argument(
        "-o", dest="file", required=True, metavar="FILE", help="the figure: .svg, .png or .pdf"
    )
    parser.add_argument("--end", metavar="T", help="draw to this time instead of the scene's end")
    parser.add_argument("--scene", metavar="SCENE", help="of a FILE: the scene that it belongs to")
    parser.add_argument(
        "--number", help="double (default), extended, quad or mp; of a FILE: what its decimals are"
    )
    parser.add_argument("--digits", type=whole, help="digits wanted; they choose the number type")


def main(options: Namespace) -> int:
    """Make one figure."""
    from polhode.common.files import check_writable, is_stdout, write_whole
    from polhode.figures import canvas

    path = Path(options.file)
    inputs = [library.path_of(name) for name in (options.what_of, options.scene) if name]
    check_writable(path, canvas.SUFFIXES, inputs)
    refuse_two_on_stdout(path, options.json)
    canvas.require()
    found = _of_file(options) if _is_file(options.what_of) else _of_scene(options)
    if isinstance(found, int):
        return found
    figure = import_module(f"polhode.figures.{options.what}")
    title = f"polhode: {options.what} of {found.name}"
    suffix = path.suffix.lower() if path.suffix.lower() in canvas.SUFFIXES else ".svg"  # a stream
    write_whole({path: canvas.drawn(figure.draw, found, suffix, title)})
    t = found.columns["t"]
    if options.json:
        shown = {"file": str(path), "what": options.what, "of": found.name, "samples": len(t)}
        print_json(shown | {"from": float(t[0]), "to": float(t[-1])})
    elif not is_stdout(path):
        say(str(path))
    return DONE


def _is_file(name: str) -> bool:
    """Whether a trajectory file is meant: an existing path that is no scene, or a .csv."""
    suffix = Path(name).suffix.lower()
    return suffix == ".csv" or (
        suffix != ".toml" and name not in library.names() and Path(name).is_file()
    )


def _of_scene(options: Namespace) -> Samples | int:
    """What the figure of a scene shows; an exit code where the run did not get there."""
    from polhode.figures import over_time, samples
    from polhode.judging.reference import reference as reference_of

    scene = library.load(options.what_of)
    if options.scene is not None:
        raise BadInput(scene.name, "--scene", options.scene, "no --scene: it is for a FILE")
    if options.what in OUTPUTS and scene.gamma is None:
        raise BadInput(scene.name, "--what", options.what, "a scene with start.gamma")
    end = None if options.end is None else _time(scene.name, options.end)
    long = options.what in OVER_TIME
    times = samples.shown_times(scene, end, over_time.SAMPLES if long else None)
    reference = reference_of(scene) if options.what == "error" else None
    with Progress("plot") as progress:
        found = samples.run(
            scene,
            times,
            OUTPUTS.get(options.what, ()),
            options.number,
            options.digits,
            progress.show,
            project=False if options.what == "integrals" else None,
        )
    if options.what == "integrals":
        note(f"{scene.name}: without projection, after which the integrals would say nothing")
    if not found.outcome.done:
        return _not_reached(found)
    if abs(times[-1]) < abs(scene.end) and end is None:
        note(
            f"{scene.name}: drawn to t = {brief(times[-1])} of {brief(scene.end)}, "
            f"{samples.WINDOW} radians; --end draws to another time"
        )
    apart = samples.radians_apart(scene, times)
    if not long and apart > 0.5:
        note(f"{scene.name}: {apart:.2g} radians between two samples: a shorter --end draws curves")
    if reference is not None:
        return over_time.errors_of_run(found, reference)
    return over_time.departures_of_run(found) if long else samples.of_run(found)


def _of_file(options: Namespace) -> Samples:
    """What the figure of a trajectory file shows."""
    from polhode.figures import over_time, samples
    from polhode.judging import table as table_
    from polhode.judging.reference import reference as reference_of
    from polhode.runs.request import choose_number

    what, path = options.what, options.what_of
    scene = None if options.scene is None else library.load(options.scene)
    if what in OVER_TIME and scene is None:
        raise BadInput(path, "--scene", None, f"the scene that the file belongs to, for {what}")
    if options.end is not None:
        raise BadInput(path, "--end", options.end, "no --end: a file is drawn whole")
    number = None
    if options.number is not None or options.digits is not None:
        if scene is None:
            raise BadInput(path, "--number", options.number, "a --scene to judge the file with it")
        number = choose_number(scene, options.number, options.digits)
    table = table_.read_table(Path(path), number)
    if what == "error" and scene is not None:
        return over_time.errors_of_table(table, reference_of(scene), number)
    if what == "integrals" and scene is not None:
        return over_time.departures_of_table(table, scene, number)
    found = samples.of_table(table, scene)
    _refuse_what_is_missing(found, what)
    return found


def _refuse_what_is_missing(found: Samples, what: str) -> None:
    """Raise BadInput where a file lacks the columns of a figure, or has too few rows."""
    wanted = {
        "angles": (any(found.has([name]) for name in ANGLES), "one of psi, theta, phi"),
        "sphere": (found.has(STATE[3:]), "columns gamma1, gamma2, gamma3"),
        "hodographs": (
            found.has(STATE[:3]) and (found.has(ATTITUDE) or found.has(SPACE)),
            "columns p, q, r and the attitude q0, q1, q2, q3 (or omega_x, omega_y, omega_z)",
        ),
    }
    there, expected = wanted[what]
    if not there:
        raise BadInput(found.name, "header", ",".join(found.columns), f"{expected} for {what}")
    if len(found.columns["t"]) < 3:
        raise BadInput(found.name, "file", None, "three rows or more, to draw a curve")


def _time(name: str, text: str) -> Exact:
    try:
        return expression.number(text)
    except ExpressionError as fault:
        raise BadInput(name, "--end", text, f"a time ({fault})") from None


def _not_reached(found: Trajectory) -> int:
    """Say why a run ended early; the exit code."""
    from polhode.taylor.outcomes import Outcome

    scene = found.scene
    note(
        f"polhode: {scene.name}: reached t = {brief(found.reached)} of {brief(scene.end)}: "
        f"{found.outcome.cause}; {found.outcome.advice}; nothing was written"
    )
    return INTERRUPTED if found.outcome is Outcome.INTERRUPTED else NOT_REACHED
