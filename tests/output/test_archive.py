"""Archives of runs that somebody changed: refused in one line, whatever stands in them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import polhode

Arrays = dict[str, Any]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Arrays:
    """The arrays of a run with events, angles and attitude."""
    scene = polhode.load("lagrange/nutation").at([0, 0.5, 1, 2])
    path = tmp_path_factory.mktemp("run") / "run.npz"
    polhode.integrate(replace(scene, events=(polhode.Event("nutation"),))).save(path)
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def about(**changed: Any) -> Callable[[Arrays], Arrays]:
    """The JSON part with some values changed."""

    def change(arrays: Arrays) -> Arrays:
        told = json.loads(str(arrays["about"])) | changed
        return arrays | {"about": np.array(json.dumps(told))}

    return change


def put(name: str, array: Any) -> Callable[[Arrays], Arrays]:
    return lambda arrays: arrays | {name: np.array(array)}


def cut(name: str) -> Callable[[Arrays], Arrays]:
    return lambda arrays: arrays | {name: arrays[name][:-1]}


CHANGES = {
    "brackets": put("about", "[" * 100_000),
    "no object": put("about", "[1]"),
    "states empty": put("states", np.array([], dtype=np.str_)),
    "states short": cut("states"),
    "states flat": lambda arrays: arrays | {"states": arrays["states"].ravel()},
    "states undefined": lambda arrays: put("states", np.full((4, 6), ""))(arrays),
    "states as doubles": put("states", np.ones((4, 6))),
    "states not finite": put("states", np.full((4, 6), "inf")),
    "times empty": put("times", np.array([], dtype=np.str_)),
    "times short": cut("times"),
    "other times": put("times", ["0", "0.5", "1", "3"]),
    "times as numbers": put("times", [0.0, 0.5, 1.0, 2.0]),
    "angles short": cut("angles"),
    "attitude of three": lambda arrays: arrays | {"attitude": arrays["attitude"][:, 1:]},
    "errors of one": put("errors", [1e-16]),
    "event's states": cut("event0_states"),
    "event's grazing": put("event0_grazing", ["x"]),
    "event's signs": put("event0_signs", [7] * 6),
    "no events": about(events=[]),
    "steps": about(steps="many"),
    "truth for steps": about(steps=True),
    "bits": about(bits=10**9),
    "bits of a double": about(bits=54),
    "number": about(number="half"),
    "bits of no mp": about(number="mp"),
    "tolerance": about(tolerance="nan"),
    "method": about(method="guess"),
    "projection": about(projection={"onto": 3}),
    "provenance": about(provenance=[]),
    "reached": about(reached="1e999999999"),
    "outcome": about(outcome="arrived"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_archive_is_refused_in_one_line(name: str, saved: Arrays, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    np.savez(path, **saved)
    polhode.load_run(path)
    np.savez(path, **CHANGES[name](saved))
    with pytest.raises(polhode.BadInput, match="a run that polhode saved") as refusal:
        polhode.load_run(path)
    assert "\n" not in str(refusal.value)


def test_damaged_bytes_are_refused(saved: Arrays, tmp_path: Path) -> None:
    """A byte in a wrong place makes zip, its decompression or numpy raise almost anything."""
    path = tmp_path / "run.npz"
    np.savez_compressed(path, **saved)
    whole = path.read_bytes()
    refused = 0
    for at in range(0, len(whole), 97):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        try:
            polhode.load_run(path)
        except polhode.BadInput:
            refused += 1
    assert refused > len(whole) // 97 * 0.8  # dates in a ZIP are nobody's business


def test_a_run_that_reached_no_output_is_archived_as_it_was(tmp_path: Path) -> None:
    """Its states came back with another shape."""
    for number in ("double", "quad"):
        run = polhode.integrate("lagrange/nutation", number, at=[1, 2], max_steps=2)
        assert run.times == ()
        run.save(tmp_path / "run.npz")
        again = polhode.load_run(tmp_path / "run.npz")
        assert again == run
        assert np.shape(again.states) == np.shape(run.states)
