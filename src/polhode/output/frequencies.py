"""Frequencies of a motion as a JSON object; names and shapes are a contract."""

from __future__ import annotations

from collections.abc import Mapping

from polhode.common.json_text import JsonObject
from polhode.dynamics.frequencies.frequencies import Frequencies


def of_frequencies(found: Frequencies) -> JsonObject:
    """The object that ``frequencies --json`` prints."""
    return {
        "source": found.name,
        "end": found.end,
        "samples": found.samples,
        "known": dict(found.known),
        "closed_form": found.closed_form,
        "frequencies": [
            {
                "signal": signal,
                "frequency": line.frequency,
                "error": line.error,
                "half": line.half,
                "amplitude": abs(line.amplitude),
                "phase": float(_phase(line.amplitude)),
                "combination": dict(line.combination),
            }
            for signal, lines in found.lines.items()
            for line in lines
        ],
        "provenance": dict(found.provenance),
    }


def _phase(amplitude: complex) -> float:
    import cmath

    return cmath.phase(amplitude)


def words(combination: Mapping[str, int]) -> str:
    """An integer combination as text."""
    return " ".join(
        f"{'-' if k < 0 else '+'} {'' if abs(k) == 1 else f'{abs(k)} '}{name}"
        for name, k in combination.items()
    ).removeprefix("+ ")
