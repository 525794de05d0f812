"""``polhode reference``: the closed form alone, or a proven enclosure of any motion."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.files import check_writable, is_stdout
from polhode.common.text_tables import counted
from polhode.numbers import number_types
from polhode.numbers.exact import Exact
from polhode.output import csv_tables, json_results
from polhode.scenes import library, start_box
from polhode.scenes.scene import Scene
from polhode.scenes.start_box import StartBox
from polhode.scenes.vocabulary import COLUMNS
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    LONG,
    NOT_REACHED,
    ProgressLine,
    note,
    positive,
    print_json,
    print_rows,
    refuse_two_on_stdout,
    seconds,
    tell_certificate,
    time_options,
    times_of,
    whole,
    word,
)

if TYPE_CHECKING:
    from polhode.enclosures.events import CertifiedEvents

#: What the JSON file next to a proven table has of the answer.
_BESIDE = ("events", "statement", "assumed", "angles_lost", "outcome", "provenance")

HELP = "the closed form alone, or a proven enclosure of any motion"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    time_options(parser)
    parser.add_argument("--digits", type=whole, default=50, help="correct digits (50)")
    parser.add_argument(
        "--events", action="store_true", help="with --certified: the scene's events, proven"
    )
    parser.add_argument(
        "--max-seconds",
        type=seconds,
        metavar="S",
        help="with --certified: a limit on the time; what is proven until then is printed",
    )
    parser.add_argument(
        "--max-steps", type=positive, metavar="N", help="with --certified: a limit on the steps"
    )
    parser.add_argument(
        "--statement",
        action="store_true",
        help="with --certified: what is proven, in words, and what it rests on",
    )
    parser.add_argument("--outputs", metavar="O,O", help=", ".join(COLUMNS))
    parser.add_argument(
        "--backend",
        default="flint",
        help="flint (balls), or mpmath: the classical tops by mpmath's own functions, states alone",
    )
    parser.add_argument(
        "--certified",
        action="store_true",
        help="a proven enclosure, of any motion: only proven digits are printed",
    )
    parser.add_argument(
        "-o",
        dest="file",
        type=word,
        metavar="FILE",
        help="x.csv: the table, and a JSON file next to it; with --certified also x.json: "
        "the certificate, for polhode verify",
    )


def main(options: Namespace) -> int:
    """The closed form alone, or the enclosure."""
    from polhode.judging.references.reference import Reference
    from polhode.judging.references.reference import reference as reference_of
    from polhode.judging.references.textbook import Textbook

    box = start_box.read(options.scene) if options.certified else None
    scene = library.load(options.scene) if box is None else box.scene
    if options.outputs is not None:
        scene = replace(scene, outputs=tuple(o for o in options.outputs.split(",") if o))
    times = times_of(options, scene)
    if not times:
        raise BadInput(scene.name, "run.end", None, "a time, or times given with --at")
    if not 1 <= options.digits <= number_types.MAX_DIGITS:
        expected = f"1 to {number_types.MAX_DIGITS}"
        raise BadInput(scene.name, "digits", options.digits, expected)
    if options.certified and options.backend != "flint":
        raise BadInput(scene.name, "--backend", options.backend, "no --certified with it")
    if not options.certified:
        for name in ("events", "max_seconds", "max_steps", "statement"):
            if getattr(options, name):
                key = "--" + name.replace("_", "-")
                raise BadInput(scene.name, key, None, "--certified with it")
    if options.events and not scene.events:
        raise BadInput(scene.name, "events", None, "events in the scene, for --events")
    path = None if options.file is None else Path(options.file)
    if path is not None:
        _check(path, options)
        refuse_two_on_stdout(path, options.json)
    if box is not None:
        return _certified(StartBox(scene, box.radii), times, options)
    if options.backend == "mpmath" and scene.outputs:
        if options.outputs is not None:
            raise BadInput(scene.name, "outputs", options.outputs, "none: mpmath has states alone")
        note(f"{scene.name}: without {', '.join(scene.outputs)}: mpmath has states alone")
        scene = replace(scene, outputs=())
    reference = reference_of(scene, backend=options.backend)
    if not isinstance(reference, Reference | Textbook):
        expected = "a scene with a closed form, or --certified"
        raise BadInput(scene.name, "reference", reference.regime, expected)
    answer = json_results.of_reference(reference, times, options.digits)
    if not reference.proven:
        note(f"{scene.name}: the digits are reproduced, not proven")
    if path is not None:
        csv_tables.write_trajectory(path, answer)
    if options.json:
        print_json(answer)
    elif path is None or not is_stdout(path):
        print_rows(answer)
    return DONE


def _check(path: Path, options: Namespace) -> None:
    """Refuse a file that cannot be written, before any work: a table, or a certificate."""
    source = library.path_of(options.scene)
    if _is_table(path, options):
        csv_tables.check_paths(path, [source])
    else:
        from polhode.certificates import certificate_file

        check_writable(path, [".csv", ".json"], [source])
        certificate_file.refuse_another(path)


def _is_table(path: Path, options: Namespace) -> bool:
    """Whether a file is to hold a table: a stream holds a certificate, if that is made."""
    return path.suffix.lower() == ".csv" or not options.certified


def _certified(box: StartBox, times: Sequence[Exact], options: Namespace) -> int:
    """A proven enclosure, and proven events; on stdout nothing but proven digits."""
    from polhode.certificates import state_certificate
    from polhode.enclosures.certify import certify
    from polhode.enclosures.events import certify_events
    from polhode.enclosures.task import MAX_STEPS
    from polhode.motion.outcomes import Outcome

    scene, radii = box
    held = json_results.held_times(scene, times, options.digits)
    path = None if options.file is None else Path(options.file)
    certificate = path is not None and not _is_table(path, options)
    if certificate:
        if radii is not None:
            raise BadInput(scene.name, start_box.KEY, None, "numbers, for a certificate")
        state_certificate.check(scene, held)
    limits: dict[str, Any] = {
        "max_steps": options.max_steps or MAX_STEPS,
        "max_seconds": options.max_seconds,
        "forecast": lambda seconds: _foretell(scene, seconds),
        "omega_radius": radii,
    }
    began = time.monotonic()
    events: tuple[CertifiedEvents, ...] = ()
    with ProgressLine("reference") as progress:
        found = certify(scene, held, digits=options.digits, progress=progress.show, **limits)
        if options.events and found.outcome.done:
            if options.max_seconds is not None:
                limits["max_seconds"] = max(1e-3, options.max_seconds - time.monotonic() + began)
            last = max(held, key=abs)
            events = certify_events(
                scene, last, digits=options.digits, progress=progress.show, **limits
            )
        if path is not None and certificate and found.times:
            found.save(path, progress.foretelling(partial(_foretell_certificate, scene)))
    answer = json_results.of_enclosure(found)
    if options.events:
        answer["events"] = [json_results.of_certified_events(event) for event in events]
    if path is not None and not certificate and found.times:
        found.save(path)
    if options.json:
        print_json(answer)
    else:
        if path is None or not is_stdout(path):
            print_rows(answer)
        for event in events:
            note(_told(event))
    least = f"at least {found.fewest:.1f} at each time" if found.times else "no time was reached"
    if certificate and found.times:
        tell_certificate(scene.name, options.file)
    if not options.json:
        note(
            f"{scene.name}: every digit is proven, {least}; {counted(found.steps, 'step')} at a "
            f"noise level of 2**-{found.noise}, {found.seconds_in_all:.1f} s"
        )
    if options.statement and not options.json:
        for line in found.statement:
            note(line)
    for what in found.assumed:
        note(f"{scene.name}: assumed by the rule for equal numbers, not proven: {what}")
    for since in found.lost:
        note(
            f"{scene.name}: psi and phi are not given beyond t = {since:.6g}: the third axis is, "
            "or passes, too near the vertical for their turns to be counted"
        )
    if found.outcome.done:
        return DONE
    cause, advice = found.outcome.cause, found.outcome.advice
    if found.outcome is Outcome.TOO_WIDE:
        cause = f"followed to t = {found.until:.6g}: {cause}"
    note(f"polhode: {scene.name}: {len(found.times)} of {len(held)} times: {cause}; {advice}")
    return INTERRUPTED if found.outcome is Outcome.INTERRUPTED else NOT_REACHED


def _foretell(scene: Scene, seconds: float) -> None:
    """What a long proof will cost, before it starts."""
    if seconds > LONG:
        note(
            f"{scene.name}: this proof will take about {seconds:.2g} s; "
            "--max-seconds S or Ctrl-C ends it sooner and keeps what is proven"
        )


def _foretell_certificate(scene: Scene, seconds: float) -> None:
    if seconds > LONG:
        note(f"{scene.name}: making the certificate will take about {seconds:.2g} s")


def _told(event: CertifiedEvents) -> str:
    """One line about proven events: how many, and the first of them."""
    from polhode.numbers.balls import guaranteed

    shown = [guaranteed(t.time, t.radius) for t in event.times[:10]]
    more = ", ..." * (len(event.times) > len(shown))
    when = f" at t = {', '.join(shown)}{more}" if shown else ""
    left = ", no others"
    if event.undecided:
        open_ = [f"{low:.6g} to {high:.6g}" for low, high in event.undecided[:3]]
        left = f"; undecided from {', '.join(open_)}" + ", ..." * (len(event.undecided) > 3)
    return f"event {event.name}: {len(event.times)} proven{when}{left}"
