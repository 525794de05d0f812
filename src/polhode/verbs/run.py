"""``polhode run``: integrate a scene."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.text_tables import counted
from polhode.numbers.decimals import brief
from polhode.output import csv_tables, json_results
from polhode.scenes import library
from polhode.scenes.vocabulary import COLUMNS
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    NOT_REACHED,
    ProgressLine,
    note,
    positive,
    print_json,
    print_rows,
    refuse_two_on_stdout,
    time_options,
    times_of,
    whole,
    word,
)

if TYPE_CHECKING:
    from polhode.motion.outcomes import EventTimes
    from polhode.runs.trajectory import Trajectory

HELP = "integrate a scene"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    digits = "correct digits wanted at every time: checked; exit code 3 if they are not reached"
    parser.add_argument("--digits", type=whole, help=digits)
    checks = parser.add_mutually_exclusive_group()
    checks.add_argument(
        "--proved",
        action="store_const",
        const=True,
        help="check the digits by a proof if no closed form is known",
    )
    checks.add_argument(
        "--unproved",
        action="store_const",
        const=False,
        dest="proved",
        help="check them by a second run, an estimate; default: by a proof if it is cheap enough",
    )
    parser.add_argument("--number", help="double (default), extended, quad or mp")
    time_options(parser)
    parser.add_argument("--tol", metavar="X", help="tolerance of a step (default: the type's eps)")
    parser.add_argument(
        "--method",
        default="auto",
        help="taylor: steps in the number type; refined: a run in double, corrected exactly; auto",
    )
    parser.add_argument("--form", metavar="F", help="form of the equations")
    parser.add_argument("--outputs", metavar="O,O", help=", ".join(COLUMNS))
    parser.add_argument("--max-steps", type=positive, metavar="N", help="limit on the steps")
    parser.add_argument(
        "--no-project", action="store_true", help="do not project the state onto the integrals"
    )
    parser.add_argument(
        "--project-every",
        type=positive,
        metavar="N",
        help="project the state onto the first integrals every N steps",
    )
    parser.add_argument(
        "-o", dest="file", type=word, metavar="FILE", help="write a CSV, and a JSON file next to it"
    )


def main(options: Namespace) -> int:
    """Integrate a scene."""
    from dataclasses import replace

    from polhode.judging.adaptive_precision import integrate
    from polhode.judging.references.reference import reference as reference_of
    from polhode.motion.outcomes import Outcome

    scene = library.load(options.scene)
    scene = scene.at(times_of(options, scene))
    if options.form is not None:
        scene = replace(scene, form=options.form)
    if options.outputs is not None:
        scene = replace(scene, outputs=tuple(o for o in options.outputs.split(",") if o))
    path = None if options.file is None else Path(options.file)
    if path is not None:
        csv_tables.check_paths(path, [library.path_of(options.scene)])
        refuse_two_on_stdout(path, options.json)
    reference = reference_of(scene)
    with ProgressLine("run") as progress:
        found = integrate(
            scene,
            options.number,
            digits=options.digits,
            tol=options.tol,
            max_steps=options.max_steps,
            project=False if options.no_project else options.project_every,
            method=options.method,
            proved=options.proved,
            progress=progress.show,
        )
    answer = json_results.of_run(found, reference.regime)
    done = found.outcome.done
    if path is not None and done:
        csv_tables.write_trajectory(path, answer)
    if options.json:
        print_json(answer)
    elif path is None:
        print_rows(answer, short=True)
    if not options.json:
        note(
            f"{scene.name}: {answer['number']} ({answer['bits']} bits), {answer['regime']}; "
            f"{answer['outcome']}, {counted(answer['steps'], 'step')}; {_accuracy(found)}"
        )
        if "not refined" in found.provenance:
            note(f"{scene.name}: not refined: {found.provenance['not refined']}")
        for event in found.events:
            note(_told(event))
    _tell_digits(found)
    if done:
        return DONE
    advice = f"; {found.advice}" if found.advice else ""
    wrote = "" if path is None else f"; {path} was not written"
    note(
        f"polhode: {scene.name}: reached t = {brief(found.reached)} of {brief(scene.end)}: "
        f"{found.cause}{advice}{wrote}"
    )
    return INTERRUPTED if found.outcome is Outcome.INTERRUPTED else NOT_REACHED


def _accuracy(found: Trajectory) -> str:
    """What a run itself tells about its accuracy."""
    if found.errors is not None:
        known = [(x, t) for x, t in zip(found.errors, found.times, strict=True) if x is not None]
        if not any(t for _, t in known):
            return "refined, without an estimate of the error"
        last = brief(max((t for _, t in known), key=abs))
        lost = "" if len(known) == len(found.errors) else f" to t = {last}, no estimate beyond it"
        return f"refined, estimated error {max(x for x, _ in known):.1e}{lost}"
    return f"projected {found.projection}" if found.projected else f"drift {found.drift}"


def _told(event: EventTimes) -> str:
    """One line about an event: how often, and when first."""
    shown_times = [
        event.shown(k) + " (grazing)" * grazing for k, grazing in enumerate(event.grazing[:10])
    ]
    more = ", ..." * (len(event.times) > len(shown_times))
    when = f" at t = {', '.join(shown_times)}{more}" if shown_times else ""
    lost = "" if event.complete else "; a zero was lost, or a pole passed"
    return f"event {event.name}: {len(event.times)}{when}{lost}"


def _tell_digits(found: Trajectory) -> None:
    """What the digits printed are worth: those found right, or where the motion takes most."""
    name, right = found.scene.name, found.correct_digits
    if right is not None:
        had = f"{json_results.round_down(right)} are right by the {found.checked_by}"
        note(f"{name}: {found.digits} digits were asked for, {had}")
        return
    expected = found.expected
    if expected.halved_after is None:
        return
    printed = found.number.printed_digits
    lost = expected.lost_after
    none = "" if lost is None else f", and none from t = {lost:.3g} on"
    note(
        f"polhode: {name}: expect fewer than half of the {printed} digits printed to be right from "
        f"t = {expected.halved_after:.3g} on{none}: this motion multiplies errors; "
        f"--digits D gives D correct ones"
    )
