"""``polhode compare`` and ``polhode order``: files that another program computed are judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.numbers.decimals import brief
from polhode.verbs.terminal import LONG, NotEnough, ProgressLine, note

if TYPE_CHECKING:
    from polhode.judging.convergence_order import ObservedOrder
    from polhode.judging.judgement import Judgement

_SECONDS = 1e-4  # about, for a radian of the motion that is followed
_MOTION_STEPS = 100_000  # a moment's work on whether the motion is chaotic
_FOLLOWED = 3e5  # radians: as far as its steps go


def judged(
    file: str | Path,
    scene: str | Path,
    number: str | None = None,
    digits: int | None = None,
    as_it_stands: bool = False,
    read: str | None = None,
    columns: Sequence[str] | None = None,
    at_least: float | None = None,
    max_seconds: float | None = None,
    details: bool = False,
    whole: bool = False,
    line: ProgressLine | None = None,
) -> Judgement:
    """Judge a trajectory that another program computed.

    Parameters
    ----------
    file : str or Path
        A CSV (- for standard input), .npz, .npy or .parquet with a column t.
    scene : str or Path
        A case that ships, or a path.
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
    at_least : float, optional
        Fail (exit code 3) if any value has fewer correct digits than this, 2 if one is missing; the
        table is then read as it stands, or as --read says.
    max_seconds : float, optional
        A limit in seconds on the proof that judges where there is no closed form.
    details : bool
        Print everything known: digits at more times and those to expect, the kind of motion, drift.
    whole : bool
        Find everything known, for data that are written.
    line : ProgressLine
        Where progress is shown.
    """
    judgement = _judged(
        Path(file),
        scene,
        line or ProgressLine("compare"),
        number=number,
        digits=digits,
        as_it_stands=as_it_stands or at_least is not None,
        read=read,
        columns=columns,
        max_seconds=max_seconds,
        details=details or whole,
    )
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
    verdict = (
        f"{judgement.worst:.2f} correct digits of {where}, where at least {at_least:g} are wanted"
    )
    raise NotEnough(judgement, f"polhode: {judgement.subject.name}: {verdict}")


def order(
    files: Sequence[str | Path],
    scene: str | Path,
    steps: Sequence[str] | None = None,
    number: str | None = None,
    digits: int | None = None,
    as_it_stands: bool = False,
    read: str | None = None,
    columns: Sequence[str] | None = None,
    max_seconds: float | None = None,
    line: ProgressLine | None = None,
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
    number : str, optional
        The type of which the files' decimals are rounded values.
    digits : int, optional
        The digits of mp, with --number mp.
    as_it_stands : bool
        Apply no other convention than the scene's.
    read : str, optional
        Readings to apply, in their words, 'omega degrees; attitude scalar-last'.
    columns : sequence of str, optional
        The files' columns in order, or some of them, as for polhode compare.
    max_seconds : float, optional
        A limit in seconds on the proof that judges where there is no closed form.
    line : ProgressLine
        Where progress is shown.
    """
    from polhode.judging.convergence_order import order_between

    if len(files) < 2:
        raise BadInput("polhode order", "FILE", None, "two files or more")
    shown, judgements = line or ProgressLine("order"), []
    for file in files:
        judgements.append(
            _judged(
                Path(file),
                scene,
                shown,
                number=number,
                digits=digits,
                as_it_stands=as_it_stands,
                read=read,
                columns=columns,
                max_seconds=max_seconds,
            )
        )
    return order_between(judgements, steps)


def _judged(
    path: Path, scene: str | Path, line: ProgressLine, max_seconds: float | None, **options: Any
) -> Judgement:
    """The judgement of a file; ``options``: others of :func:`polhode.compare`."""
    from polhode.judging.certified import ProofTooLong
    from polhode.judging.compare import compare
    from polhode.proofs.certified_orbit import NotProved

    def foretold(seconds: float) -> None:
        if seconds > LONG:
            line.clear()
            note(
                f"{path}: there is no closed form here, and the proof that judges will take "
                f"about {seconds:.2g} s; --max-seconds S or Ctrl-C ends it sooner"
            )

    try:
        judgement = compare(
            path,
            scene,
            progress=partial(line.show, what="rows or steps of the reference"),
            max_seconds=max_seconds,
            forecast=foretold,
            **options,
        )
    except ProofTooLong as fault:
        raise NotProved(str(fault)) from None
    angle = 10.0**judgement.reference.scene.log10_rate * max(abs(float(t)) for t in judgement.times)
    if (seconds := _SECONDS * min(angle, _FOLLOWED)) > LONG:
        line.clear()
        effort = f"the motion is followed through {angle:.2g} radians for the digits to expect"
        note(f"{path}: {effort}, up to some {seconds:.0f} s; Ctrl-C ends it")
    return judgement
