"""Every kind of result saves itself, loads again, draws itself and becomes a table."""

from __future__ import annotations

import json
import re
from fractions import Fraction

import numpy as np
import pytest
from matplotlib import pyplot as plt

import polhode
from polhode.cli import main
from shared.results import result_of_kind, watched
from shared.tools import tiers

#: Kinds that have no figure.
UNDRAWN = (
    *("About", "Cases", "CheckReport", "CheckReport of bands", "Conditioning", "Description"),
    *(
        "Description in other axes",
        "ProvedOrbits",
        "ReferenceTable",
        "Report",
        "Textbook",
        "Verdict",
    ),
)


@pytest.mark.parametrize("name", tiers(["Trajectory", "ChaosMap"], ["Trajectory in quad"]))
def test_results_draw_themselves_and_into_axes_of_ones_own(name):
    result = result_of_kind(name)
    panels = np.ravel(np.asarray(result.plot(), dtype=object))
    if name.startswith("Trajectory"):
        _, mine = plt.subplots()
        assert result.plot(ax=mine) is mine
        assert mine.lines
    else:
        _, mine = plt.subplots(len(panels), squeeze=False)
        drawn = result.plot(ax=mine if len(panels) > 1 else mine[0, 0])
        assert list(np.ravel(np.asarray(drawn, dtype=object))) == list(mine[:, 0])
        assert all(a.lines or a.collections for a in mine[:, 0])
        again = np.ravel(np.asarray(polhode.plot(result), dtype=object))
        assert len(again) == len(panels)
    plt.close("all")


@pytest.mark.parametrize(
    ("key", "value", "printed"),
    [
        ("number", "double", 17),
        ("number", "extended", 21),
        ("number", "quad", 36),
    ],
)
def test_times_of_events_have_the_digits_of_their_type_wherever_they_are_printed(
    key, value, printed, tmp_path, capsys
):
    scene = tmp_path / "scene.toml"
    scene.write_text(polhode.as_toml(watched().at((10,))))
    command = ["run", str(scene), f"--{key}", str(value)]
    assert main([*command, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    first = answer["events"]["t"][0]
    assert main(command) == 0
    said = capsys.readouterr().err
    time = re.search(r"at t = ([0-9.]+)", said)[1]
    assert len(time) == printed + 1 + (time[0] == "0")  # and the point
    assert abs(Fraction(time) - Fraction(first)) <= Fraction(1, 2 * 10**printed)
    run = polhode.integrate(str(scene), **{key: value})
    assert repr(run.events[0]).endswith(f"the first at t = {time}>")


def test_a_certificate_is_no_result_and_says_what_it_is(tmp_path):
    path = tmp_path / "proof.json"
    result_of_kind("Enclosure").save(path)
    with pytest.raises(polhode.BadInput, match=r"certificate, which polhode\.verify checks"):
        polhode.load_result(path)
