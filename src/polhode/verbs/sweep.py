"""``polhode sweep``: many tops at once."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.text_tables import counted
from polhode.motion.outcomes import code
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.verbs.terminal import (
    DONE,
    NOT_REACHED,
    ProgressLine,
    goes_on,
    note,
    positive,
    print_json,
    print_table,
    refuse_two_on_stdout,
    time_options,
    times_of,
    whole,
    word,
)

if TYPE_CHECKING:
    from polhode.dynamics.observables.reduce_many import Reductions
    from polhode.runs.sweep.ensemble import Ensemble

HELP = "many tops at once: numbers of a scene varied; not projected, not checked"


_AT_ONCE = 100_000  # states that are written within a second


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument(
        "--vary",
        metavar="KEY=FROM:TO:N",
        action="append",
        help="a number of the scene file, such as start.omega[1] or body.weight, and N values for "
        "it evenly spaced, or KEY=a,b,c; given several times: every combination",
    )
    parser.add_argument(
        "--starts",
        type=word,
        metavar="FILE",
        help="instead: a start for each member, p,q,r,gamma1,gamma2,gamma3 in the rows of a CSV or "
        "NPY file",
    )
    digits = "digits wanted: choose the number type by the fastest member, and are not checked"
    parser.add_argument("--digits", type=whole, help=digits)
    parser.add_argument("--number", help="double (default), extended, quad or mp")
    time_options(parser)
    parser.add_argument("--tol", metavar="X", help="tolerance of a step (default: the type's eps)")
    parser.add_argument(
        "--method", default="auto", help="taylor, refined or auto, as in polhode run"
    )
    parser.add_argument("--max-steps", type=positive, metavar="N", help="limit on a member's steps")
    parser.add_argument("--workers", type=positive, metavar="N", help="threads (all cores)")
    parser.add_argument(
        "--keep",
        metavar="WHAT",
        action="append",
        help="numbers of each member instead of its states: final, 'largest X', 'smallest X' (X an "
        "expression in the columns, t, theta, over the output times), 'first EVENT', lyapunov; "
        "may be repeated",
    )
    output = "FILE.npz or FILE.csv; the same command continues a killed sweep from FILE.npz.parts"
    parser.add_argument("-o", dest="file", type=word, metavar="FILE", help=output)


def main(options: Namespace) -> int:
    """Integrate many variants of a scene."""
    from polhode.output import sweeps
    from polhode.runs.sweep.ensemble import Ensemble

    scene = library.load(options.scene)
    scene = scene.at(times_of(options, scene))
    scene, varied = _varied(options, scene)
    path = None if options.file is None else Path(options.file)
    if path is not None:
        inputs = [library.path_of(options.scene), options.starts and Path(options.starts)]
        sweeps.check_path(path, inputs)
        refuse_two_on_stdout(path, options.json)
    with ProgressLine("sweep") as progress:

        def tell(fraction: float, done: int) -> None:
            progress.show(fraction, done, "members")

        found = _found(options, scene, varied, path, tell)
    if path is not None and not (found.interrupted and _takes_long(found)):
        _write(path, found)
        if found.parts is not None and not found.interrupted:
            found.parts.remove()
    if isinstance(found, Ensemble):
        words = [word for word in scene.outputs if word not in found.outputs]
        left_out = f"; {', '.join(words)} left out" if words else ""
    else:
        left_out = ""
    if options.json:
        print_json(_answer(found))
    elif path is None:
        print_table(*_table(found))
    if not options.json:
        unchecked = ""
        if options.digits is not None:
            unchecked = f"; number type chosen for {options.digits} digits, members not checked"
        note(
            f"{scene.name}: {counted(len(found), 'member')}, "
            f"{found.number.name} ({found.number.bits} bits), not projected{left_out}{unchecked}; "
            + ", ".join(f"{n} {outcome.value}" for outcome, n in found.tally().items())
        )
    for outcome in found.tally():
        if not outcome.done:
            advice = f"; {outcome.advice}" if outcome.advice else ""
            first = found.endings.tolist().index(code(outcome))
            note(f"polhode: {found.members[first].name}: {outcome.cause}{advice}")
    if found.interrupted:
        return goes_on(found.parts)
    return DONE if found.done else NOT_REACHED


def _varied(options: Namespace, scene: Scene) -> tuple[Scene, dict[str, Any]]:
    """What is varied, and the scene of which it is; raises BadInput."""
    from polhode.runs.sweep import starts_file
    from polhode.runs.sweep.array_starts import from_starts
    from polhode.scenes.variation import vary

    if (options.starts is None) == (options.vary is None):
        given = None if options.vary is None else ", ".join(options.vary)
        raise BadInput(scene.name, "--vary", given, "numbers to vary or --starts FILE, one of them")
    if options.starts is None:
        return scene, vary.options(options.vary, scene.name, scene.units)
    rows = starts_file.read(Path(options.starts), scene, options.number == "extended")
    return from_starts(scene, rows)


def _found(
    options: Namespace,
    scene: Scene,
    varied: dict[str, Any],
    path: Path | None,
    tell: Callable[[float, int], None],
) -> Ensemble | Reductions:
    """The members' states, or what is kept of each."""
    from polhode.common import checkpoint
    from polhode.dynamics.observables.reduce_many import reduce_many
    from polhode.runs.sweep.integrate_many import integrate_many

    parts = None if path is None else checkpoint.beside(path)
    shared: dict[str, Any] = {
        "number": options.number,
        "tol": options.tol,
        "max_steps": options.max_steps,
        "workers": options.workers,
        "parts": parts,
        "progress": tell,
    }
    if options.keep is None:
        method, digits = options.method, options.digits
        return integrate_many(scene, varied, digits=digits, method=method, **shared)
    if options.digits is not None:
        raise BadInput(scene.name, "--digits", options.digits, "--number instead, with --keep")
    return reduce_many(scene, varied, options.keep, **shared)


def _takes_long(found: Ensemble | Reductions) -> bool:
    """Whether what there is would be written after Ctrl-C for seconds; the parts are kept."""
    from polhode.runs.sweep.ensemble import Ensemble

    many = isinstance(found, Ensemble) and len(found) * len(found.times) > _AT_ONCE
    return many and found.parts is not None


def _write(path: Path, found: Ensemble | Reductions) -> None:
    from polhode.output import reductions, sweeps
    from polhode.runs.sweep.ensemble import Ensemble

    if isinstance(found, Ensemble):
        sweeps.write(path, found)
    else:
        reductions.write(path, found)


def _answer(found: Ensemble | Reductions) -> dict[str, Any]:
    from polhode.output import reductions, sweeps
    from polhode.runs.sweep.ensemble import Ensemble

    if isinstance(found, Ensemble):
        return sweeps.of_ensemble(found)
    return reductions.of_reductions(found)


def _table(found: Ensemble | Reductions) -> tuple[list[str], list[list[str]]]:
    from polhode.output import reductions, sweeps
    from polhode.runs.sweep.ensemble import Ensemble

    return sweeps.table(found) if isinstance(found, Ensemble) else reductions.table(found)
