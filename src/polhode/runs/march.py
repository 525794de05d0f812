"""An integrator led through the output times, chunk by chunk."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TypeAlias

from polhode.numbers.scalars import Row
from polhode.taylor.outcomes import Outcome
from polhode.taylor.protocols import Integrating

#: Called now and then with the fraction of the time done and the steps taken.
Progress: TypeAlias = Callable[[float, int], None]


def march(
    integrator: Integrating,
    times: list[Fraction],
    rows: list[Row],
    limit: int,
    chunk: int,
    progress: Progress | None,
) -> Outcome:
    """Advance chunk by chunk, appending a row for each time reached; the outcome."""
    end = times[-1]
    try:
        while len(rows) < len(times):
            steps = min(chunk, limit - integrator.steps)
            if steps <= 0:
                return Outcome.STEP_LIMIT
            before = integrator.time
            found, outcome = integrator.chunk(times[len(rows) :], steps)
            if outcome is Outcome.NON_FINITE:
                rows.extend(row for row in found if all(x - x == 0 for x in row))
                return outcome
            rows.extend(found)
            if outcome is not Outcome.STEP_LIMIT:
                return outcome
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
