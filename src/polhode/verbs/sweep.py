"""``polhode sweep``: many tops at once."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.scenes import library
from polhode.verbs.terminal import (
    DONE,
    NOT_REACHED,
    Progress,
    goes_on,
    note,
    positive,
    print_json,
    print_table,
    read_times,
    refuse_two_on_stdout,
    whole,
)

HELP = "many tops at once: numbers of a scene varied; bare steps, not projected"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument(
        "--vary",
        metavar="KEY=FROM:TO:N",
        action="append",
        required=True,
        help="a number of the scene file, such as start.omega[1] or body.weight, and N values for "
        "it evenly spaced, or KEY=a,b,c; several: every combination",
    )
    digits = "digits wanted; they choose the number type, by the fastest member; not checked"
    parser.add_argument("--digits", type=whole, help=digits)
    parser.add_argument("--number", help="double (default), extended, quad or mp")
    parser.add_argument("--at", metavar="T,T...", help="output times instead of the scene's")
    parser.add_argument(
        "--tol", metavar="X", help="tolerance of a step, the type's eps unless given"
    )
    parser.add_argument(
        "--method", default="auto", help="taylor, refined or auto, as in polhode run"
    )
    parser.add_argument("--max-steps", type=positive, metavar="N", help="limit on a member's steps")
    parser.add_argument("--workers", type=positive, metavar="N", help="threads (all cores)")
    output = "write FILE.npz or FILE.csv; a killed sweep, given again, goes on from FILE.npz.parts"
    parser.add_argument("-o", dest="file", metavar="FILE", help=output)


def main(options: Namespace) -> int:
    """Integrate many variants of a scene."""
    from polhode.output import sweeps
    from polhode.runs import kept_folder
    from polhode.runs.sweep import integrate_many
    from polhode.scenes import vary

    scene = library.load(options.scene)
    if options.at is not None:
        scene = scene.at(read_times(scene, options.at))
    varied = vary.options(options.vary, scene.name)
    path = None if options.file is None else Path(options.file)
    if path is not None:
        sweeps.check_path(path, [library.path_of(options.scene)])
        refuse_two_on_stdout(path, options.json)
    with Progress("sweep") as progress:
        found = integrate_many(
            scene,
            varied,
            number=options.number,
            digits=options.digits,
            tol=options.tol,
            max_steps=options.max_steps,
            method=options.method,
            workers=options.workers,
            parts=None if path is None else kept_folder.beside(path),
            progress=lambda fraction, done: progress.show(fraction, done, "members"),
        )
    if path is not None:
        sweeps.write(path, found)
        if found.parts is not None and not found.interrupted:
            found.parts.remove()
    if options.json:
        print_json(sweeps.of_ensemble(found))
    elif path is None:
        print_table(*sweeps.table(found))
    if not options.json:
        left_out = f"; {', '.join(scene.outputs)} left out" if scene.outputs else ""
        unchecked = ""
        if options.digits is not None:
            unchecked = f"; a type for {options.digits} digits, no member checked"
        note(
            f"{scene.name}: {len(found)} members, {found.number.name} ({found.number.bits} bits), "
            f"not projected{left_out}{unchecked}; "
            + ", ".join(f"{n} {outcome.value}" for outcome, n in found.tally().items())
        )
    for outcome in found.tally():
        if not outcome.done:
            advice = f"; {outcome.advice}" if outcome.advice else ""
            first = found.outcomes.index(outcome)
            note(f"polhode: {found.members[first].name}: {outcome.cause}{advice}")
    if found.interrupted:
        return goes_on(found.parts)
    return DONE if found.done else NOT_REACHED
