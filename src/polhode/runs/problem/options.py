"""What was asked of a run, checked: number type, times and tolerance."""

from __future__ import annotations

from fractions import Fraction

from polhode.common.arguments import of_kind, whole
from polhode.common.errors import BadInput, nearest, plain
from polhode.numbers import number_types
from polhode.numbers.conversion import exact_number
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import AnyNumber
from polhode.scenes.output_times import OutputTimes
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults


def choose_number(
    scene: Scene, number: str | NumberType | None, digits: int | None, lost: float = 0.0
) -> NumberType:
    """The number type that was named, or the cheapest one that holds the digits wanted.

    ``lost``: the digits that the motion is expected to lose, where that was measured.
    """
    name = number.name if isinstance(number, NumberType) else number
    if name is not None:
        listed = ", ".join(number_types.NAMES)
        of_kind(scene.name, "number", name, str, f"{listed}, or a NumberType")
    if name is not None and name not in number_types.NAMES:
        raise BadInput(scene.name, "number", name, nearest(name, list(number_types.NAMES)))
    if name == "extended" and not number_types.extended_here():
        raise BadInput(scene.name, "number", name, "quad: long double has no 64 bits here")
    if digits is not None:
        digits = whole(scene.name, "digits", digits, 1, number_types.MAX_DIGITS)
    if isinstance(number, NumberType):
        return number
    if digits is None:
        return number_types.named(number or "double")
    chosen = number_types.for_digits(digits, scene.log10_angle, lost)
    if number is None or number == chosen.name:
        return chosen
    if number == "mp":
        return number_types.mp_for(digits, scene.log10_angle, lost)
    if number_types.named(number).bits < chosen.bits:
        raise BadInput(scene.name, "digits", digits, f"fewer in {number}; {chosen.name} holds them")
    return number_types.named(number)


def rounded_times(scene: Scene, number: NumberType) -> OutputTimes[Fraction]:
    """The output times as numbers of the run's type."""
    if not scene.times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    times = scene.output_times.rounded(number)
    k = times.misplaced()
    if k is not None:
        expected = f"times that differ when rounded to {number.name}"
        raise BadInput(scene.name, f"run.at[{k + 1}]", str(float(times[k])), expected)
    return times


def rounded_tolerance(scene: Scene, number: NumberType, tol: AnyNumber | None) -> Fraction | None:
    """The tolerance of a step, checked; None for the type's eps."""
    if tol is None:
        return None
    try:
        wanted = exact_number(tol)
    except (TypeError, ValueError):
        raise BadInput(scene.name, "tol", plain(tol), "a number") from None
    if not isinstance(wanted, Fraction) or not number.eps <= wanted <= Fraction(1, 10):
        lowest = f"{float(number.eps):.3g}" if number.bits < 1000 else f"2**-{number.bits - 1}"
        raise BadInput(scene.name, "tol", plain(tol), f"between eps = {lowest} and 0.1")
    return wanted


def cadence(
    scene: Scene, number: NumberType, tolerance: Fraction | None, project: bool | int | None
) -> int | None:
    """Steps between two corrections of the run, None for none."""
    if project is not None and not isinstance(project, bool):
        project = whole(scene.name, "project", project, 1)
    if project is None:
        full = tolerance is None or tolerance <= number.eps
        project = full and defaults.of(number).projected
    if scene.form != "principal" or project is False:
        return None
    return defaults.of(number).project_every if project is True else project
