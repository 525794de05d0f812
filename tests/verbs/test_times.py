"""Output times on the command line: the same options, read alike, of every verb that has them."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

from polhode.cli import main

CASE = "lagrange/nutation"  # 81 times to t = 40
THIRD = Fraction(1, 3)

TIMES = {
    "--at 1,2.5": [1, Fraction(5, 2)],
    "--at 0:1:3,5": [0, Fraction(1, 2), 1, 5],
    "--at -1/3": [-THIRD],
    "--at 2:2:1": [2],
    "--at 0:-1:4,-2:-3:2": [0, -THIRD, -2 * THIRD, -1, -2, -3],
    "--end 1 --samples 3": [0, Fraction(1, 2), 1],
    "--end -1 --samples 2": [0, -1],
    "--samples 3": [0, 20, 40],
    "--end 8": [Fraction(k, 10) for k in range(81)],
    "--every 16": [0, 16, 32],
    "--end 1 --every 1/3": [0, THIRD, 2 * THIRD, 1],
    "--end 1 --every 0.1": [Fraction(k, 10) for k in range(11)],
    "--end -1 --every 0.3": [-Fraction(3 * k, 10) for k in range(4)],
    "--end 1.9999999999999999999 --every 1": [0, 1],
    "--end 5 --every 5": [0, 5],
}


def times_told(capsys, verb: str, options: str) -> list[Fraction]:
    """The times of a verb's answer."""
    more = ["--vary", "start.omega[1]=0"] if verb == "sweep" else []
    assert main([verb, CASE, *more, *options.split(), "--json"]) == 0
    times = json.loads(capsys.readouterr().out)["columns"]["t"]
    return [Fraction(t) for t in times]


@pytest.mark.parametrize(
    ("verb", "options"),
    [("run", options) for options in TIMES]
    + [(verb, options) for verb in ("reference", "sweep") for options in [*TIMES][1::4]],
)
def test_times_are_those_asked_for(verb, options, capsys):
    """In double, but for the last digit printed."""
    times = times_told(capsys, verb, options)
    assert len(times) == len(TIMES[options])
    for time, right in zip(times, TIMES[options], strict=True):
        assert abs(time - right) <= abs(right) * Fraction(2) ** -52
