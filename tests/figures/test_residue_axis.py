"""The axis of residues in the figure of an orbit search."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import polhode


@pytest.fixture(scope="module")
def search():
    return polhode.orbit_search("general/asymmetric-regular", (4, 4), crossings=1)


@pytest.mark.parametrize(
    "residues", [(0.93, 0.93 + 1e-13), (), (-40_000.0, 300.0), (0.5, 1e30), (-3.0, 0.2)]
)
def test_the_axis_of_residues(search, residues):
    """It holds 0, 1 and all residues, its labels are plain, and rounding errors are not apart."""
    plt = pytest.importorskip("matplotlib.pyplot")
    one = search.orbits[0]
    orbits = [one._replace(residue=x, period=2.5 + 1e-13 * k) for k, x in enumerate(residues)]
    found = dataclasses.replace(search, orbits=tuple(orbits))
    _, axes = plt.subplots()
    found.plot(axes)
    axes.figure.canvas.draw()
    low, high = axes.get_ylim()
    assert low < min(0, *residues, 0)
    assert high > max(1, *residues, 1)
    ticks = {t.get_text(): t.get_position()[1] for t in axes.get_yticklabels()}
    assert {"0", "1"} <= set(ticks)
    assert len(ticks) <= 16
    for text, at in ticks.items():
        assert float(text.replace("\N{MINUS SIGN}", "-")) == pytest.approx(at, rel=1e-12)
    assert sorted(line.get_ydata()[0] for line in axes.lines[-2:]) == [0, 1]
    if residues:
        assert np.ptp(axes.get_xlim()) >= 0.09
    plt.close(axes.figure)
