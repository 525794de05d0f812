"""Scene and number type to trajectory: the main job."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode import kinematics, library, precision
from polhode.errors import BadInput, nearest
from polhode.exact import Exact
from polhode.forms import Functions, principal
from polhode.precision import NumberType, exact_time
from polhode.provenance import provenance
from polhode.readout import Readout, number_value
from polhode.scene import ATTITUDE, Scene
from polhode.trajectory import Outcome, Trajectory

Progress = Callable[[float, int], None]


def integrate(
    scene: Scene | str | Path,
    number: str | NumberType | None = None,
    *,
    digits: int | None = None,
    at: Sequence[Any] | None = None,
    tol: Any = None,
    max_steps: int | None = None,
    inputs: NumberType | None = None,
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate the Euler–Poisson equations (3.29) of a scene with heyoka's Taylor method.

    ``number``: double (default), extended, quad or mp (50 digits), or a NumberType.  ``digits``:
    the digits wanted, which choose the number type.  ``at``: output times instead of the scene's.
    ``tol``: the tolerance of a step, the type's eps unless given.  ``inputs``: round start and
    coefficients to this narrower type first, to see what that rounding alone does.  ``progress``:
    called now and then with the fraction of the time done and the steps taken.

    Ctrl-C ends the run within a second; the trajectory then holds what was reached.  Raises
    BadInput for what cannot be integrated.
    """
    if not isinstance(scene, Scene):
        scene = library.load(scene)
    if at is not None:
        scene = scene.at(tuple(exact_time(t) for t in at))
    if scene.events:
        names = ", ".join(event.name for event in scene.events)
        raise BadInput(scene.name, "events", names, "none: events are not located yet")
    chosen = choose_number(scene, number, digits)
    tolerance = _tolerance(scene, chosen, tol)
    times = _rounded_times(scene, chosen)
    run = _Run(scene, chosen, tolerance, max_steps, inputs)
    outcome, rows = run.to(times, progress)
    read = Readout(scene, chosen)

    return Trajectory(
        scene=scene,
        number=chosen,
        times=tuple(times[: len(rows)]),
        states=read.states(rows),
        attitude=read.attitude(rows),
        angles=read.angles(rows),
        outcome=outcome,
        steps=run.steps,
        reached=run.reached,
        tolerance=float(tolerance or chosen.eps),
        digits=digits,
        provenance={
            **provenance(scene.source),
            "seconds": {"build": run.build_seconds, "run": run.seconds - run.build_seconds},
        },
    )


def choose_number(scene: Scene, number: str | NumberType | None, digits: int | None) -> NumberType:
    """The number type that was named, or the cheapest one that holds the digits wanted."""
    if isinstance(number, NumberType):
        return number
    if number is not None and number not in precision.NAMES:
        raise BadInput(scene.name, "number", number, nearest(number, list(precision.NAMES)))
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


class _Run:
    """One integration under way, in principal axes and the scene's own unit of time."""

    def __init__(
        self,
        scene: Scene,
        number: NumberType,
        tolerance: Fraction | None,
        max_steps: int | None,
        inputs: NumberType | None,
    ) -> None:
        self.scene, self.number, self.tolerance = scene, number, tolerance
        self.max_steps = max_steps
        self.unit = Fraction(2) ** scene.time_unit
        axes, gamma = scene.body.axes, scene.gamma
        self.names = [*scene.columns]
        start: list[Exact] = [self.unit * w for w in axes.components(scene.omega)]
        k = principal.coefficients(scene.body, scene.time_unit)
        if gamma is not None:
            start += axes.components(gamma)
            if scene.outputs:
                k |= kinematics.turn_coefficients(axes)
            if "attitude" in scene.outputs:
                self.names += ATTITUDE
                start += kinematics.starting_attitude(gamma, scene.psi)
            if "angles" in scene.outputs:
                self.names += ("psi", "phi")
                start += [scene.psi, kinematics.starting_phi(gamma)]
        if inputs is not None:
            start = [inputs.rounded(x) for x in start]
            k = {name: inputs.rounded(x) for name, x in k.items()}
        self.start, self.coefficients = start, k
        self.steps = 0
        self.reached = Fraction(0)
        self.build_seconds = self.seconds = 0.0

    def field(self, state: Sequence[Any], k: Mapping[str, Any], fn: Functions) -> list[Any]:
        """Rates of the state and of what the outputs ask for."""
        columns = len(self.scene.columns)
        rates = principal.field(state[:columns], k, fn)
        if not self.scene.outputs:
            return rates
        omega, gamma = (kinematics.in_scene_axes(state[i : i + 3], k, fn.zero) for i in (0, 3))
        if "attitude" in self.scene.outputs:
            rates += kinematics.attitude_rates(state[columns : columns + 4], omega)
        if "angles" in self.scene.outputs:
            rates += kinematics.angle_rates(omega, gamma)
        return rates

    def to(self, times: list[Fraction], progress: Progress | None) -> tuple[Outcome, list[Any]]:
        """Rows at the times, as far as they were reached, and the outcome."""
        from polhode import taylor

        rows: list[Any] = []
        if times[0] == 0:
            rows.append([number_value(x, self.number) for x in self.start])
        if len(rows) == len(times):
            return Outcome.REACHED_END, rows
        began = time.perf_counter()
        try:
            integrator = taylor.Taylor(
                self.names,
                lambda state, k: self.field(state, k, taylor.EXPRESSIONS),
                self.coefficients,
                self.start,
                self.number,
                self.tolerance,
            )
            self.build_seconds = time.perf_counter() - began
            inside = times if self.unit == 1 else [t / self.unit for t in times]
            limit = self.max_steps if self.max_steps is not None else taylor.max_steps(self.number)
            chunk = taylor.chunk_steps(self.number)
            outcome = _march(integrator, inside, rows, limit, chunk, progress)
        except taylor.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        self.seconds = time.perf_counter() - began
        self.steps = integrator.steps
        self.reached = integrator.time * self.unit
        return outcome, rows


def _march(
    integrator: Any,
    times: list[Fraction],
    rows: list[Any],
    limit: int,
    chunk: int,
    progress: Progress | None,
) -> Outcome:
    """Advance chunk by chunk, appending a row for each time reached; the outcome."""
    from polhode import taylor

    end = times[-1]
    try:
        while len(rows) < len(times):
            steps = min(chunk, limit - integrator.steps)
            if steps <= 0:
                return Outcome.STEP_LIMIT
            before = integrator.time
            found, ended = integrator.chunk(times[len(rows) :], steps)
            if not taylor.finite(ended):
                return Outcome.NON_FINITE
            rows.extend(found)
            if taylor.at_end(ended):
                break
            passed = abs(integrator.time - before)
            if passed <= steps * abs(integrator.time) * integrator.number.eps:
                return Outcome.STEP_UNDERFLOW
            ahead = abs(end - integrator.time) / passed * steps
            if integrator.steps + ahead > 10 * limit:  # hopeless: no need to try the limit out
                return Outcome.STEP_LIMIT
            if progress is not None:
                progress(float(integrator.time / end), integrator.steps)
    except KeyboardInterrupt:
        return Outcome.INTERRUPTED
    return Outcome.REACHED_END


def _rounded_times(scene: Scene, number: NumberType) -> list[Fraction]:
    """The output times as numbers of the run's type."""
    if not scene.times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    times = [number.rounded(t) for t in scene.times]
    for k in range(1, len(times)):
        if times[k] == times[k - 1]:
            raise BadInput(
                scene.name,
                f"run.at[{k + 1}]",
                str(float(times[k])),
                f"times that differ when rounded to {number.name}",
            )
    return times


def _tolerance(scene: Scene, number: NumberType, tol: Any) -> Fraction | None:
    if tol is None:
        return None
    try:
        wanted = exact_time(tol)
    except ValueError:
        raise BadInput(scene.name, "tol", str(tol), "a number") from None
    if not isinstance(wanted, Fraction) or not number.eps <= wanted <= Fraction(1, 10):
        lowest = f"{float(number.eps):.3g}" if number.bits < 1000 else f"2**-{number.bits - 1}"
        raise BadInput(scene.name, "tol", str(tol), f"between eps = {lowest} and 0.1")
    return wanted
