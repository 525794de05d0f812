"""Proofs that are stopped: what was proven until then is kept, and said to be that."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import polhode
from polhode import Outcome, cli
from shared.tables import ANGLES, ATTITUDE

SCENE = "general/asymmetric-regular"
EVENTS = """
[[events]]
name = "level"
zero = "gamma3 - 9/10"
"""
_LOOKS = 8  # at the clock, in which a proof comes past its first time and not to its second


class _Clock:
    """A clock that stands still for so many looks, and is far on from then."""

    def __init__(self, looks: int) -> None:
        self.left = looks

    def __call__(self) -> float:
        self.left -= 1
        return 0.0 if self.left >= 0 else 1e9


def _stand(monkeypatch: pytest.MonkeyPatch, looks: int) -> None:
    """The clock of all deadlines."""
    monkeypatch.setattr(time, "monotonic", _Clock(looks))


def _stop(fraction: float, _: int) -> None:
    if fraction > 0.3:
        raise KeyboardInterrupt


def test_what_was_proven_until_an_interruption_is_kept() -> None:
    whole = polhode.certify(SCENE, at=[1, 5, 60], digits=15)
    enclosure = polhode.certify(SCENE, at=[60, 1, 5], digits=15, progress=_stop)
    assert enclosure.outcome is Outcome.INTERRUPTED
    assert not enclosure.complete
    assert enclosure.times == (1, 5)
    assert enclosure.centres == whole.centres[:2]
    assert "interrupted" in repr(enclosure)


def test_what_was_proven_until_a_limit_on_the_time_is_kept(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _stand(monkeypatch, 2)  # in the first window
    nothing = polhode.certify(SCENE, at=[60], digits=15, max_seconds=2)
    assert nothing.times == nothing.centres == nothing.digits == ()
    assert repr(nothing) == f"<Enclosure of {SCENE}: 0 times, time limit>"
    _stand(monkeypatch, 10**9)
    whole = polhode.certify(SCENE, at=[1, 60], digits=15)
    _stand(monkeypatch, _LOOKS)
    enclosure = polhode.certify(SCENE, at=[1, 60], digits=15, max_seconds=3)
    assert enclosure.outcome is Outcome.TIME_LIMIT
    assert enclosure.times == (1,)
    assert enclosure.centres[0] == whole.centres[0]
    _stand(monkeypatch, _LOOKS + 3)  # of the command line
    words = ("certify", SCENE, "--digits", "15", "--at", "1,60", "--json")
    assert cli.main((*words, "--max-seconds", "3")) == 3
    out, err = capsys.readouterr()
    assert json.loads(out)["outcome"] == "time limit"
    assert json.loads(out)["columns"]["t"] == ["1"]
    assert "1 of 2 times: the end needs more seconds" in err


def test_the_cost_is_foretold_once_and_grows_with_time_and_digits() -> None:
    seconds: list[float] = []
    polhode.certify(SCENE, at=[1], digits=15, forecast=seconds.append)
    polhode.certify(SCENE, at=[2], digits=15, forecast=seconds.append)
    polhode.certify(SCENE, at=[2], digits=30, forecast=seconds.append)
    assert len(seconds) == 3
    assert 0 < seconds[0] < 0.7 * seconds[1] < 0.5 * seconds[2]


def test_events_after_an_interruption_are_undecided() -> None:
    scene = replace(polhode.load(SCENE), events=(polhode.Event("level", "gamma3 - 9/10"),))
    (whole,) = polhode.certify_events(scene, end=60)
    (events,) = polhode.certify_events(scene, end=60, progress=_stop)
    assert whole.proven
    assert not events.proven
    begin, end = events.undecided[-1]
    assert 0 < begin < 60 == end
    assert 0 < len(events.times) < len(whole.times)
    assert all(t.time + Fraction(t.radius) <= begin + 1e-9 for t in events.times)
    before = [t for t in whole.times if float(t.time) < begin - 1e-6]
    assert [round(float(t.time), 12) for t in events.times] == [
        round(float(t.time), 12) for t in before
    ]


def test_angles_attitude_and_events_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "watched.toml"
    path.write_text(polhode.load(SCENE).source + EVENTS, encoding="utf-8")
    options = ("--digits", "15", "--at", "2,8", "--outputs", "angles,attitude")
    assert cli.main(("certify", str(path), *options, "--events", "--json")) == 0
    answer = json.loads(capsys.readouterr().out)
    radii = [answer["columns"][f"{name}_radius"] for name in (*ANGLES, *ATTITUDE)]
    assert 0 < max(map(max, radii)) <= 1e-15
    events = answer["events"]
    assert len(events["t"]) == len(events["t_radius"]) > 0
    run = polhode.integrate(str(path), "quad", at=[8], method="taylor")
    for text, radius, t in zip(events["t"], events["t_radius"], run.events[0].times, strict=True):
        assert abs(Fraction(text) - t) <= Fraction(radius) + Fraction(1, 10**30)
