"""``polhode plot``: figures of a motion, from a scene or from a trajectory file."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.scenes import library
from polhode.scenes.given_numbers import TIME, in_text
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, SPACE, STATE
from polhode.verbs.options import whole, word
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    NOT_REACHED,
    ProgressLine,
    note,
    print_json,
    refuse_two_on_stdout,
    say,
)

if TYPE_CHECKING:
    from polhode.figures.canvas.curve_sampling import Samples
    from polhode.figures.film import Look
    from polhode.judging.tables.table import Table
    from polhode.numbers.number_types import NumberType
    from polhode.runs.trajectory import Trajectory

HELP = "a figure of a motion, from a scene or a trajectory file"
CHAOS = "chaos-proof"
KINDS = (
    *("angles", "omega", "momentum", "attitude", "hodographs", "sphere", "motion"),
    *("integrals", "error"),
    CHAOS,
)


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "what_of", type=word, metavar="SCENE|FILE", help="a case, a scene's path, or a table"
    )
    parser.add_argument("--what", required=True, choices=KINDS, help="the kind of figure")
    parser.add_argument(
        "-o",
        dest="file",
        type=word,
        required=True,
        metavar="FILE",
        help="the figure: .svg, .png or .pdf; motion: .html, .gif or .mp4",
    )
    parser.add_argument("--end", metavar="T", help="draw to this time instead of the scene's end")
    parser.add_argument(
        "--scene", type=word, metavar="SCENE", help="for a FILE: the scene that it belongs to"
    )
    parser.add_argument(
        "--number", help="double (default), extended, quad or mp; for a FILE: that of its decimals"
    )
    table_options(parser)
    digits = "digits wanted, by which the number type is chosen"
    parser.add_argument("--digits", type=whole, help=digits)
    parser.add_argument(
        "--size", type=whole, metavar="PIXELS", help="of a film: pixels of a side (360)"
    )
    parser.add_argument("--fps", type=whole, metavar="N", help="of a film: frames a second (20)")


def table_options(parser: ArgumentParser) -> None:
    """The options by which a file is read, as ``compare`` has them."""
    parser.add_argument(
        "--read",
        metavar="WORDS",
        help="for a FILE: the conventions to read it in, as for compare: 'omega degrees'",
    )
    parser.add_argument(
        "--columns",
        metavar="NAMES",
        help="for a FILE: its columns in order, t,qw,qx,...; or some: 'time_ms=t*1e-3, Q.W=q0'",
    )


def main(options: Namespace) -> int:
    """Make one figure."""
    from polhode.common.files import called, check_writable, is_stdout, write_whole
    from polhode.figures import film
    from polhode.figures.canvas import canvas
    from polhode.figures.drawing import page_of

    path = Path(options.file)
    inputs = [library.path_of(name) for name in (options.what_of, options.scene) if name]
    moving = options.what == "motion"
    suffixes = (".html", *film.SUFFIXES) if moving else canvas.SUFFIXES
    if not moving and path.suffix.lower() in (".html", *film.SUFFIXES):
        expected = f"{', '.join(canvas.SUFFIXES)}; --what motion makes a page or a film"
        raise BadInput(str(path), "-o", None, f"a name that ends in {expected}")
    check_writable(path, suffixes, inputs)
    refuse_two_on_stdout(path, options.json)
    suffix = path.suffix.lower() if path.suffix.lower() in suffixes else suffixes[0]  # a stream
    if suffix != ".html":
        canvas.require()
    look = _look(options, moving and suffix in film.SUFFIXES)
    film.require(suffix, look)
    if options.what == CHAOS:
        return _chaos(options, path, suffix)
    found = samples_of(options)
    if isinstance(found, int):
        return found
    if moving and is_file(options.what_of):
        warn_of_motion(found)
    made: str | bytes
    t = found.columns["t"]
    shown = {"from": float(t[0]), "to": float(t[-1])}
    if suffix == ".html":
        made = page_of(
            found,
            f"polhode plot {called(Path(options.what_of))} --what motion",
            is_file(options.what_of),
        )
    elif moving:
        with ProgressLine("plot") as progress:
            filmed = film.filmed(
                found, suffix, lambda done: progress.say(f"{100 * done:.0f} %"), look
            )
        made = filmed.data
        if filmed.closed:
            shown["to"] = filmed.end
            again = f"at t = {filmed.end:.6g} the motion is as at t = {filmed.begin:g}"
            note(f"{found.name}: {again}, to {film.CLOSED:.0e}: the film ends there, and repeats")
    else:
        figure = import_module(f"polhode.figures.{options.what}")
        made = canvas.drawn(figure.draw, found, suffix, f"polhode: {options.what} of {found.name}")
    write_whole({path: made})
    if options.json:
        told = {"file": str(path), "what": options.what, "of": found.name, "samples": len(t)}
        print_json(told | shown)
    elif not is_stdout(path):
        say(str(path))
    return DONE


def _look(options: Namespace, filmed: bool) -> Look:
    """Size and rate of a film; refused of anything else."""
    from polhode.figures.film import Look

    given = {"size": options.size, "rate": options.fps}
    for key, value in (("--size", options.size), ("--fps", options.fps)):
        if value is not None and not filmed:
            raise BadInput("plot", key, value, "a film: --what motion with -o x.gif or x.mp4")
    return Look(**{key: value for key, value in given.items() if value is not None})


def _chaos(options: Namespace, path: Path, suffix: str) -> int:
    """The figure of a proof of chaos, of a scene's level."""
    from polhode.common.files import is_stdout, write_whole
    from polhode.figures import chaos_proof
    from polhode.figures.canvas import canvas
    from polhode.proofs.chaos.prove_chaos import prove_chaos
    from polhode.proofs.refusals import NotProved

    for key in ("end", "scene", "number", "digits", "read", "columns"):
        if getattr(options, key) is not None:
            expected = f"not with --what {CHAOS}"
            raise BadInput(options.what_of, f"--{key}", getattr(options, key), expected)
    with ProgressLine("plot") as progress:
        try:
            found = prove_chaos(options.what_of, progress=progress.say)
        except NotProved as why:
            progress.clear()
            note(f"polhode: not proved: {why}")
            return NOT_REACHED
    title = f"polhode: proof of chaos of {found.scene.name}"
    write_whole({path: canvas.drawn(chaos_proof.draw, found, suffix, title)})
    if options.json:
        print_json({"file": str(path), "what": CHAOS, "of": found.scene.name})
    elif not is_stdout(path):
        say(str(path))
    return DONE


def is_file(name: str) -> bool:
    """Whether a trajectory file is meant: by its ending, or an existing path that is no scene."""
    from polhode.judging.tables.table_file import ENDINGS

    suffix = Path(name).suffix.lower()
    return suffix in (".csv", *ENDINGS) or (
        suffix != ".toml" and not library.ships(name) and os.path.isfile(name)
    )


def samples_of(options: Namespace) -> Samples | int:
    """What a figure shows, of a scene or a file; an exit code where a run did not get there."""
    return _of_file(options) if is_file(options.what_of) else _of_scene(options)


def _of_scene(options: Namespace) -> Samples | int:
    """What the figure of a scene shows; an exit code where the run did not get there."""
    from polhode.figures.canvas import curve_sampling, over_time
    from polhode.figures.drawing import FREE_OF_GAMMA, OUTPUTS, OVER_TIME
    from polhode.judging.references.reference import reference as reference_of

    scene = library.load(options.what_of)
    for key in ("scene", "read", "columns"):
        if (value := getattr(options, key)) is not None:
            raise BadInput(scene.name, f"--{key}", value, f"no --{key}: it is for a FILE")
    if options.what not in FREE_OF_GAMMA and scene.gamma is None:
        raise BadInput(scene.name, "--what", options.what, "a scene with start.gamma")
    end = None if options.end is None else _time(scene, options.end)
    long = options.what in OVER_TIME
    times = curve_sampling.shown_times(scene, end, over_time.SAMPLES if long else None)
    reference = reference_of(scene) if options.what == "error" else None
    with ProgressLine("plot") as progress:
        found = curve_sampling.run(
            scene,
            times,
            OUTPUTS["sphere" if options.what == "motion" else options.what],
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
            f"{curve_sampling.WINDOW} radians; --end draws to another time"
        )
    apart = curve_sampling.radians_apart(scene, times)
    if not long and apart > 0.5:
        note(f"{scene.name}: {apart:.2g} radians between two samples: a shorter --end draws curves")
    if reference is not None:
        return over_time.errors_of_run(found, reference)
    return over_time.departures_of_run(found) if long else curve_sampling.of_run(found)


def _of_file(options: Namespace) -> Samples:
    """What the figure of a trajectory file shows."""
    from polhode.figures.canvas import curve_sampling, over_time
    from polhode.figures.drawing import OVER_TIME
    from polhode.judging.references.reference import reference as reference_of
    from polhode.runs.problem.options import choose_number

    what, path = options.what, options.what_of
    scene = None if options.scene is None else library.load(options.scene)
    if what in (*OVER_TIME, "momentum", "motion") and scene is None:
        raise BadInput(path, "--scene", None, f"the scene that the file belongs to, for {what}")
    if options.end is not None:
        raise BadInput(path, "--end", options.end, "no --end: a file is drawn whole")
    number = None
    if options.number is not None or options.digits is not None:
        if scene is None:
            raise BadInput(path, "--number", options.number, "a --scene to judge the file with it")
        number = choose_number(scene, options.number, options.digits)
    table = _table(options, scene, number)
    if what == "error" and scene is not None:
        return over_time.errors_of_table(table, reference_of(scene), number)
    if what == "integrals" and scene is not None:
        return over_time.departures_of_table(table, scene, number)
    found = curve_sampling.of_table(table, scene)
    _refuse_what_is_missing(found, what)
    return found


def _table(options: Namespace, scene: Scene | None, number: NumberType | None) -> Table:
    """The table of a file, in the conventions that were told."""
    from polhode.judging.diagnosis.told_readings import table_as_told
    from polhode.judging.references.reference import reference
    from polhode.judging.tables.naming import PLAIN, naming
    from polhode.judging.tables.table_file import read_table

    path = Path(options.what_of)
    names = PLAIN if options.columns is None else naming(options.columns)
    found = read_table(path, number, names)
    if options.read is None:
        return found
    if scene is None:
        raise BadInput(str(path), "--read", options.read, "a --scene whose conventions are meant")
    return table_as_told(found, reference(scene), options.read)


def warn_of_motion(found: Samples) -> None:
    """Say on stderr what a file that is shown in motion is not."""
    from polhode.figures.sampled_motion import ANOTHER, of_samples

    motion = of_samples(found)
    if far := motion.coarse():
        note(f"{found.name}: {far}")
    if not motion.on_level():
        told = "polhode compare FILE SCENE says which convention or cause"
        note(f"{found.name}: {ANOTHER[0].lower()}{ANOTHER[1:].rstrip('.')}; {told}")


def _refuse_what_is_missing(found: Samples, what: str) -> None:
    """Raise BadInput where a file lacks the columns of a figure, or has too few rows."""
    wanted = {
        "omega": (any(found.has([name]) for name in STATE[:3]), "one of p, q, r"),
        "momentum": (found.has(STATE[:3]), "columns p, q, r"),
        "attitude": (found.has(ATTITUDE), "columns q0, q1, q2, q3"),
        "motion": (found.has((*STATE[:3], *ATTITUDE)), "columns p, q, r and q0, q1, q2, q3"),
        "angles": (any(found.has([name]) for name in ANGLES), "one of psi, theta, phi"),
        "sphere": (found.has(STATE[3:]), "columns gamma1, gamma2, gamma3"),
        "hodographs": (
            found.has(STATE[:3]) and (found.has(ATTITUDE) or found.has(SPACE)),
            "columns p, q, r and the attitude q0, q1, q2, q3 (or omega_x, omega_y, omega_z)",
        ),
    }
    there, expected = wanted[what]
    if not there:
        expected = f"{expected} for {what}"
        if what == "angles" and found.has(ATTITUDE):
            expected += "; --what attitude draws its q0, q1, q2, q3"
        raise BadInput(found.name, "header", ",".join(found.columns), expected)
    if len(found.columns["t"]) < 3:
        raise BadInput(found.name, "file", None, "three rows or more, to draw a curve")


def _time(scene: Scene, text: str) -> Exact:
    try:
        return in_text(text, scene.units, TIME)
    except ExpressionError as fault:
        raise BadInput(scene.name, "--end", text, f"a time ({fault})") from None


def _not_reached(found: Trajectory) -> int:
    """Say why a run ended early; the exit code."""
    from polhode.motion.outcomes import Outcome

    scene = found.scene
    note(
        f"polhode: {scene.name}: reached t = {brief(found.reached)} of {brief(scene.end)}: "
        f"{found.outcome.cause}; {found.outcome.advice}; nothing was written"
    )
    return INTERRUPTED if found.outcome is Outcome.INTERRUPTED else NOT_REACHED
