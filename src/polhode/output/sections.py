"""A section as a JSON object and as arrays; names and shapes are a contract."""

from __future__ import annotations

from typing import TYPE_CHECKING

from polhode.common import json_text
from polhode.common.json_text import JsonObject
from polhode.dynamics.sections.section import Section
from polhode.numbers.decimals import shown

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


def of_section(found: Section) -> JsonObject:
    """The object that ``section --json`` prints: a list an orbit, as long as it has crossings."""

    def rows(array: npt.NDArray[np.generic]) -> list[list[float]]:
        return [row[:n].tolist() for row, n in zip(array, found.counts, strict=True)]

    return {
        **_about(found),
        "starts": found.starts.tolist(),
        "start_states": found.start_states.tolist(),
        "l": rows(found.l),
        "L_over_G": rows(found.ratio),
        "times": rows(found.times),
        "rests": rows(found.rests),
        "states": rows(found.states),
        "digits": [[None if x != x else round(x, 2) for x in row] for row in rows(found.digits)],
        "none_left_from": [n or None for n in found.none_left_from.tolist()],
        "outcomes": list(found.outcomes),
        "provenance": dict(found.provenance),
    }


def arrays(found: Section) -> JsonObject:
    """The arrays of an NPZ file, none of which needs pickle; ``state`` is (n, 6, m)."""
    import numpy as np

    return {
        "start": found.starts,
        "start_state": found.start_states,
        "state": np.swapaxes(found.states, 1, 2),
        "time": found.times,
        "rest": found.rests,
        "l": found.l,
        "L_over_G": found.ratio,
        "digits": found.digits,
        "none_left_from": found.none_left_from,
        "count": found.counts,
        "outcome": np.array(found.outcomes),
        "about": np.array(
            json_text.as_json(_about(found) | {"provenance": dict(found.provenance)})
        ),
    }


def _about(found: Section) -> JsonObject:
    return {
        "scene": found.scene.name,
        "h": shown(found.h),
        "f": shown(found.f),
        "by": found.by,
        "extremum": found.extremum,
        "drift": found.drift,
        "complete": found.complete,
    }
