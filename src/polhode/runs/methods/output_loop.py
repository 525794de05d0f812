"""An integrator led through the output times, chunk by chunk."""

from __future__ import annotations

from typing import TYPE_CHECKING

from polhode.common.progress import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import joined
from polhode.numbers.rows import Rows
from polhode.taylor.backend.time_grid import Times

if TYPE_CHECKING:
    from polhode.taylor.integrator.stepping import Integrator


def march(
    integrator: Integrator,
    times: Times,
    rows: Rows,
    limit: int,
    chunk: int,
    progress: Progress | None,
) -> tuple[Rows, Outcome]:
    """Advance chunk by chunk; ``rows`` and one more for each time reached, and the outcome."""
    end, parts, done = times.end, [rows], len(rows)
    try:
        while done < len(times):
            steps = min(chunk, limit - integrator.steps)
            if steps <= 0:
                outcome = Outcome.STEP_LIMIT
                break
            begun = integrator.time
            found, outcome = integrator.chunk(times[done:] if done else times, steps)
            if outcome is Outcome.NON_FINITE:
                finite = [k for k, row in enumerate(found) if all(x - x == 0 for x in row)]
                found = [found[k] for k in finite] if isinstance(found, list) else found[finite]
            parts.append(found)
            done += len(found)
            if outcome is not Outcome.STEP_LIMIT:
                break
            passed = abs(integrator.time - begun)
            if passed <= steps * abs(integrator.time) * integrator.number.eps:
                outcome = Outcome.STEP_UNDERFLOW
                break
            ahead = abs(end - integrator.time) / passed * steps
            if integrator.steps + ahead > 10 * limit:  # hopeless: no need to try the limit out
                break
            if progress is not None:
                progress(float(integrator.time / end), integrator.steps)
        else:
            outcome = Outcome.REACHED_END
    except KeyboardInterrupt:
        outcome = Outcome.INTERRUPTED
    return joined([part for part in parts if len(part)] or [rows], integrator.number), outcome
