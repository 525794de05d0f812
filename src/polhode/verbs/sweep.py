"""``polhode sweep``: the states of many tops, or what is kept of each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.numbers.number_types import AnyNumber
from polhode.scenes import vary
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.dynamics.reduce_many import Reductions
    from polhode.runs.ensemble import Ensemble


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
    from polhode.runs import integrate_many as starts_file
    from polhode.runs.integrate_many import from_starts, integrate_many

    if (starts is None) == (vary is None):
        keys = None if vary is None else ", ".join(map(str, vary))
        raise BadInput(scene.name, "--vary", keys, "numbers to vary or --starts FILE, one of them")
    varied: Any = vary
    if starts is not None:
        rows = starts_file.read(Path(starts), scene, number == "extended")
        scene, varied = from_starts(scene, rows)
    how: dict[str, Any] = {
        "number": number,
        "tol": tol,
        "max_steps": max_steps,
        "workers": workers,
        "parts": parts,
        "progress": progress,
    }
    if keep is None:
        return integrate_many(scene, varied, digits=digits, method=method or "auto", **how)
    if digits is not None:
        raise BadInput(scene.name, "--digits", digits, "--number instead, with --keep")
    return reduce_many(scene, varied, keep, **how)
