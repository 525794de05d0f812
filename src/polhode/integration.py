"""Scene and number type to trajectory: the main job."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode import library, precision
from polhode.dense import Dense
from polhode.errors import BadInput, nearest
from polhode.precision import NumberType, exact_number
from polhode.provenance import provenance
from polhode.readout import Readout
from polhode.run import Progress, Run
from polhode.scene import Scene
from polhode.trajectory import Trajectory

#: Steps between two corrections onto the first integrals: a tenth of the steps' own time or less.
_EVERY = {"double": 320, "extended": 32, "quad": 1, "mp": 1}


def integrate(
    scene: Scene | str | Path,
    number: str | NumberType | None = None,
    *,
    digits: int | None = None,
    at: Sequence[Any] | None = None,
    tol: Any = None,
    max_steps: int | None = None,
    inputs: NumberType | None = None,
    project: bool | int | None = None,
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate the Euler–Poisson equations (3.29) of a scene with heyoka's Taylor method.

    ``number``: double (default), extended, quad or mp (50 digits), or a NumberType.  ``digits``:
    the digits wanted, which choose the number type.  ``at``: output times instead of the scene's.
    ``tol``: the tolerance of a step, the type's eps unless given.  ``inputs``: round start and
    coefficients to this narrower type first, to see what that rounding alone does.  ``project``:
    put the state back on the exact scene's first integrals every so many steps, True as often as
    costs about a tenth of the run's time, False never; left out, as True in double and extended at
    full tolerance, else never (a form other than the principal one never).  ``progress``: called
    now and then with the fraction of the time done and the steps taken.

    The trajectory can be called at any time that it reached, see :class:`polhode.dense.Dense`.
    Ctrl-C ends the run within a second; the trajectory then holds what was reached.  Raises
    BadInput for what cannot be integrated.
    """
    if not isinstance(scene, Scene):
        scene = library.load(scene)
    if at is not None:
        scene = scene.at(tuple(exact_number(t) for t in at))
    chosen = choose_number(scene, number, digits)
    tolerance = rounded_tolerance(scene, chosen, tol)
    times = rounded_times(scene, chosen)
    every = None if inputs is not None else _cadence(scene, chosen, tolerance, project)
    run = Run(scene, chosen, tolerance, max_steps, inputs, every)
    outcome, rows = run.to(times, progress)
    read = Readout(scene, chosen)
    return Trajectory(
        scene=scene,
        number=chosen,
        times=tuple(times[: len(rows)]),
        states=read.states(rows),
        attitude=read.attitude(rows),
        angles=read.angles(rows),
        events=run.events,
        projection=run.projection,
        outcome=outcome,
        steps=run.steps,
        reached=run.reached,
        tolerance=float(tolerance or chosen.eps),
        digits=digits,
        provenance={
            **provenance(scene.text),
            "seconds": {"build": run.build_seconds, "run": run.seconds - run.build_seconds},
        },
        dense=Dense(run),
    )


def _cadence(
    scene: Scene, number: NumberType, tolerance: Fraction | None, project: bool | int | None
) -> int | None:
    """Steps between two corrections of the run, None for none."""
    if project is not None and project is not False and project < 1:
        raise BadInput(scene.name, "project", project, "True, False or steps, 1 or more")
    if project is None:
        full = tolerance is None or tolerance <= number.eps
        project = full and number.name in ("double", "extended")
    if scene.form != "principal" or project is False:
        return None
    return _EVERY[number.name] if project is True else int(project)


def choose_number(scene: Scene, number: str | NumberType | None, digits: int | None) -> NumberType:
    """The number type that was named, or the cheapest one that holds the digits wanted."""
    name = number.name if isinstance(number, NumberType) else number
    if name is not None and name not in precision.NAMES:
        raise BadInput(scene.name, "number", name, nearest(name, list(precision.NAMES)))
    if name == "extended" and not precision.extended_here():
        raise BadInput(scene.name, "number", name, "quad: long double has no 64 bits here")
    if isinstance(number, NumberType):
        return number
    if digits is not None and not 1 <= digits <= precision.MAX_DIGITS:
        raise BadInput(scene.name, "digits", digits, f"1 to {precision.MAX_DIGITS}")
    if digits is None:
        return precision.named(number or "double")
    chosen = precision.for_digits(digits, scene.log10_angle)
    if number is None or number == chosen.name:
        return chosen
    if number == "mp":
        return precision.mp_for(digits, scene.log10_angle)
    if precision.named(number).bits < chosen.bits:
        raise BadInput(scene.name, "digits", digits, f"fewer in {number}; {chosen.name} holds them")
    return precision.named(number)


def rounded_times(scene: Scene, number: NumberType) -> list[Fraction]:
    """The output times as numbers of the run's type."""
    if not scene.times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    times = [number.rounded(t) for t in scene.times]
    parts = [t.as_integer_ratio() for t in times]
    for k in range(1, len(times)):
        if parts[k] == parts[k - 1]:
            raise BadInput(
                scene.name,
                f"run.at[{k + 1}]",
                str(float(times[k])),
                f"times that differ when rounded to {number.name}",
            )
    return times


def rounded_tolerance(scene: Scene, number: NumberType, tol: Any) -> Fraction | None:
    """The tolerance of a step, checked; None for the type's eps."""
    if tol is None:
        return None
    try:
        wanted = exact_number(tol)
    except ValueError:
        raise BadInput(scene.name, "tol", str(tol), "a number") from None
    if not isinstance(wanted, Fraction) or not number.eps <= wanted <= Fraction(1, 10):
        lowest = f"{float(number.eps):.3g}" if number.bits < 1000 else f"2**-{number.bits - 1}"
        raise BadInput(scene.name, "tol", str(tol), f"between eps = {lowest} and 0.1")
    return wanted
