"""What verbs do that no public function does in one call, each with the verb's own parameters."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

from polhode.common.errors import BadInput
from polhode.common.interrupts import Message, Progress
from polhode.numbers.decimals import brief
from polhode.verbs.terminal import LONG, NotEnough, ProgressLine, note

if TYPE_CHECKING:
    from polhode.dynamics.families import OrbitSearch
    from polhode.dynamics.orbit import Orbit
    from polhode.dynamics.reduce_many import Reductions
    from polhode.enclosures.result import Enclosure
    from polhode.judging.convergence_order import ObservedOrder
    from polhode.judging.judgement import Judgement
    from polhode.numbers.number_types import AnyNumber
    from polhode.runs.ensemble import Ensemble
    from polhode.scenes import vary
    from polhode.scenes.library import StartBox
    from polhode.scenes.scene import Scene

_SECONDS = 1e-4  # about, for a radian of the motion that is followed
_MOTION_STEPS = 100_000  # a moment's work on whether the motion is chaotic
_FOLLOWED = 3e5  # radians: as far as its steps go


class FileOptions(TypedDict, total=False):
    """How a file that another program made is read and judged.

    Parameters
    ----------
    number : str, optional
        The type of which the file's decimals are rounded values.
    digits : int, optional
        The digits of mp, with --number mp.
    as_it_stands : bool
        Apply no other convention than the scene's.
    read : str, optional
        Readings to apply, in their words, 'omega degrees; attitude scalar-last'.
    columns : sequence of str, optional
        The file's columns in order, t,qw,qx,..., or some of them, 'time_ms=t*1e-3, Q.W=q0'.
    max_seconds : float, optional
        A limit in seconds on the proof that judges where there is no closed form.
    """

    number: str | None
    digits: int | None
    as_it_stands: bool
    read: str | None
    columns: Sequence[str] | None
    max_seconds: float | None


def judged(
    file: str | Path,
    scene: str | Path,
    at_least: float | None = None,
    details: bool = False,
    whole: bool = False,
    line: ProgressLine | None = None,
    **how: Unpack[FileOptions],
) -> Judgement:
    """Judge a trajectory that another program computed.

    Parameters
    ----------
    file : str or Path
        A CSV (- for standard input), .npz, .npy or .parquet with a column t and others, such as
        p,q,r,gamma1,gamma2,gamma3.
    scene : str or Path
        A case that ships, or a path.
    at_least : float, optional
        Fail (exit code 3) if any value has fewer correct digits than this, 2 if one is missing; the
        table is then read as it stands, or as --read says.
    details : bool
        Print everything known: digits at more times and those to expect, the kind of motion, drift.
    whole : bool
        Find everything known, for data that are written.
    line : ProgressLine
        Where progress is shown.
    """
    if at_least is not None:
        how["as_it_stands"] = True
    shown = line or ProgressLine("compare")
    judgement = _judged(Path(file), scene, shown, details or whole, **how)
    if details or whole:
        from polhode.dynamics.lyapunov import lyapunov
        from polhode.taylor import heyoka

        if heyoka.installed:
            motion = lyapunov(judgement.reference.scene, max_steps=_MOTION_STEPS)
            judgement = replace(judgement, motion=motion)
    if at_least is None:
        return judgement
    from polhode.judging.compare import refuse_incomplete

    refuse_incomplete(judgement)
    if judgement.worst >= at_least:
        return judgement
    where = f"{judgement.worst_part} at t = {brief(judgement.worst_time)}"
    verdict = f"{judgement.worst:.2f} correct digits of {where}"
    sentence = f"{verdict}, where at least {at_least:g} are wanted"
    raise NotEnough(judgement, f"polhode: {judgement.subject.name}: {sentence}")


def order(
    files: Sequence[str | Path],
    scene: str | Path,
    steps: Sequence[str] | None = None,
    line: ProgressLine | None = None,
    **how: Unpack[FileOptions],
) -> ObservedOrder:
    """Find the order of a method between files made with different steps.

    Parameters
    ----------
    files : sequence of str or Path
        Two files or more, as for polhode compare.
    scene : str or Path
        A case that ships, or a path.
    steps : sequence of str, optional
        The files' step sizes, if they are not the spacing of the rows.
    line : ProgressLine
        Where progress is shown.
    """
    from polhode.judging.convergence_order import order_between

    if len(files) < 2:
        raise BadInput("polhode order", "FILE", None, "two files or more")
    shown = line or ProgressLine("order")
    return order_between([_judged(Path(file), scene, shown, **how) for file in files], steps)


def _judged(
    path: Path,
    scene: str | Path,
    line: ProgressLine,
    details: bool = False,
    **options: Unpack[FileOptions],
) -> Judgement:
    """The judgement of a file; ``options``: others of :func:`polhode.compare`."""
    from polhode.judging.compare import compare
    from polhode.judging.reference import ProofTooLong
    from polhode.proofs.theorem import NotProved

    def foretold(seconds: float) -> None:
        if seconds > LONG:
            line.clear()
            note(
                f"{path}: there is no closed form here, and the proof that judges will take "
                f"about {seconds:.2g} s; --max-seconds S or Ctrl-C ends it sooner"
            )

    try:
        show = partial(line.show, what="rows or steps of the reference")
        judgement = compare(
            path, scene, progress=show, forecast=foretold, details=details, **options
        )
    except ProofTooLong as fault:
        raise NotProved(str(fault)) from None
    angle = 10.0**judgement.reference.scene.log10_rate * max(abs(float(t)) for t in judgement.times)
    if (seconds := _SECONDS * min(angle, _FOLLOWED)) > LONG:
        line.clear()
        effort = f"the motion is followed through {angle:.2g} radians for the digits to expect"
        note(f"{path}: {effort}, up to some {seconds:.0f} s; Ctrl-C ends it")
    return judgement


def sweep(
    scene: Scene,
    vary: vary.Vary | None = None,
    starts: str | Path | None = None,
    keep: list[str] | None = None,
    number: str | None = None,
    digits: int | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    workers: int | None = None,
    method: str | None = None,
    parts: Path | None = None,
    progress: Progress | None = None,
) -> Ensemble | Reductions:
    """Integrate many variants of a scene: their states, or numbers of each.

    Parameters
    ----------
    scene : Scene
        A case that ships, or a path.
    vary : list of str, optional
        A number of the scene file, such as start.omega[1] or body.weight, and N evenly spaced
        values of it, or KEY=a,b,c; may be repeated, for every combination.
    starts : str or Path, optional
        A file with one start per row instead, p q r gamma1 gamma2 gamma3.
    keep : list of str, optional
        Numbers of each member instead of its states, among final, 'largest X', 'smallest X' (X an
        expression in the columns, t, theta, over the output times), 'first EVENT', lyapunov; may be
        repeated.
    number : str, optional
        The number type, double (default), extended, quad or mp.
    digits : int, optional
        Choose the number type for this many digits of the fastest member (not checked).
    tol : number, optional
        The tolerance of a step (the type's eps by default).
    max_steps : int, optional
        A limit on a member's steps.
    workers : int, optional
        Threads, as many as there are cores unless given.
    method : str, optional
        How members are integrated, taylor, refined or auto, as in polhode run.
    parts : Path, optional
        A folder for finished jobs.
    progress : callable, optional
        Called with the fraction of members done and how many.
    """
    from polhode.dynamics.reduce_many import reduce_many
    from polhode.runs.integrate_many import integrate_many

    if (starts is None) == (vary is None):
        keys = None if vary is None else ", ".join(map(str, vary))
        raise BadInput(scene.name, "--vary", keys, "numbers to vary or --starts FILE, one of them")
    rows = None
    if starts is not None:
        from polhode.judging.tables.table_file import read_starts

        rows = read_starts(Path(starts), scene, number == "extended")
    how: dict[str, Any] = {
        "starts": rows,
        "number": number,
        "tol": tol,
        "max_steps": max_steps,
        "workers": workers,
        "parts": parts,
        "progress": progress,
    }
    if keep is None:
        return integrate_many(scene, vary, digits=digits, method=method or "auto", **how)
    if digits is not None:
        raise BadInput(scene.name, "--digits", digits, "--number instead, with --keep")
    if method is not None:
        raise BadInput(scene.name, "--method", method, "none with --keep: Taylor steps alone")
    return reduce_many(scene, vary, keep, **how)


def certified(
    scene: StartBox,
    digits: int = 50,
    events: bool = False,
    max_steps: int | None = None,
    max_seconds: float | None = None,
    certificate: bool = False,
    line: ProgressLine | None = None,
) -> Enclosure:
    """Enclose the exact motion of any body in proven balls.

    Parameters
    ----------
    scene : StartBox
        A case that ships, or a path; in a file omega may have intervals.
    digits : int
        Digits to prove at every time (50).
    events : bool
        Prove the scene's events, too.
    max_steps : int, optional
        A limit on the steps.
    max_seconds : float, optional
        A limit on the time in seconds; what is proven until then is printed.
    certificate : bool
        Whether a certificate is asked for.
    line : ProgressLine
        Where progress is shown.
    """
    from polhode.certificates import state_certificate
    from polhode.enclosures.certify import certify, certify_events
    from polhode.enclosures.task import MAX_STEPS
    from polhode.judging.reference_table import held_times
    from polhode.scenes.library import BOX_KEY

    top, radii = scene
    if events and not top.events:
        raise BadInput(top.name, "events", None, "events in the scene, for --events")
    moments = held_times(top, top.times, digits)
    if not moments:
        raise BadInput(top.name, "run.end", None, "a time, or times given with --at")
    if certificate:
        if radii is not None:
            raise BadInput(top.name, BOX_KEY, None, "numbers, for a certificate")
        state_certificate.check(top, moments)

    def foretell(seconds: float) -> None:
        if seconds > LONG:
            note(
                f"{top.name}: this proof will take about {seconds:.2g} s; "
                "--max-seconds S or Ctrl-C ends it sooner and keeps what is proven"
            )

    began = time.monotonic()
    how: dict[str, Any] = {
        "digits": digits,
        "max_steps": max_steps or MAX_STEPS,
        "max_seconds": max_seconds,
        "forecast": foretell,
        "omega_radius": radii,
        "progress": None if line is None else line.show,
    }
    enclosure = certify(top, moments, **how)
    if not events or not enclosure.outcome.done:
        return enclosure
    if max_seconds is not None:
        how["max_seconds"] = max(1e-3, max_seconds - time.monotonic() + began)
    return replace(enclosure, events=certify_events(top, max(moments, key=abs), **how))


def orbits(
    scene: str | Path,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    pick: int | None = None,
    digits: int | None = None,
    progress: Message | None = None,
) -> OrbitSearch | Orbit:
    """Search a level for periodic orbits; orbits between the cells may be missed.

    Parameters
    ----------
    scene : Scene, str or Path
        A case that ships, or a path.
    grid : tuple of int, optional
        The cells of the section's coordinates l and L/G (20x20 unless given).
    crossings : int, optional
        The largest number of crossings in a period (3 unless given).
    h, f : number, optional
        The level's energy h or vertical momentum f, if not the scene's.
    pick : int, optional
        The number of one orbit of the list, which is then computed as polhode orbit does; -o x.toml
        its start as a scene.
    digits : int, optional
        With --pick, the correct digits of start and period (15, at most 300).
    progress : callable, optional
        Called with a line of text now and then.
    """
    from polhode.dynamics.families import orbit_search
    from polhode.dynamics.orbit import DIGITS

    if pick is None and digits is not None:
        raise BadInput(str(scene), "--digits", digits, "it with --pick K, of one orbit")
    search = orbit_search(scene, grid, crossings, h, f, progress)
    if pick is None:
        return search
    if not 1 <= pick <= len(search.orbits):
        expected = f"a number to {len(search.orbits)}: so many orbits were found"
        raise BadInput(search.scene.name, "pick", pick, expected)
    return search.orbit(pick - 1, DIGITS if digits is None else digits)
