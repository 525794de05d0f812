"""What the guide says of the figures' colours and scales is what they have."""

from __future__ import annotations

import colorsys
import re

import pytest

from polhode.dynamics.levels.levels import topology
from polhode.figures import levels, map
from polhode.output import guide

HUES = {  # in degrees
    "blue": (200, 240),
    "yellow": (40, 60),
    "green": (90, 140),
    "violet": (260, 290),
    "red": (0, 20),
    "pink": (310, 345),
    "brown": (30, 40),
}


def hue(colour):
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return 360 * colorsys.rgb_to_hls(red, green, blue)[0]


def rows():
    """Colour, edges and name of the table of regions."""
    found = re.findall(r"^\| (\w+) \| ([\d, ]+) \| (.+) \|$", guide.page("dynamics"), re.M)
    return {tuple(numbers(edges)): (colour, text) for colour, edges, text in found}


def numbers(edges):
    return [int(k) for k in edges.split(",")]


@pytest.mark.parametrize("region", levels.SHADES)
def test_the_guide_names_the_colours_of_regions(region):
    colour, text = rows()[region]
    low, high = HUES[colour]
    assert low <= hue(levels.SHADES[region]) < high
    assert text.startswith(levels.name(region))
    if len(region) == 1 and region[0] < 3:
        assert f"`{topology(region)}`" in text


def test_the_guide_names_the_scales_of_maps():
    text = " ".join(guide.page("dynamics").split())
    assert f"at {map.TOPS['fli']:g} at most for FLI" in text
    assert f"at {map.TOPS['megno']:g} at most for MEGNO" in text
    for kind in map.KINDS:
        assert f"| `{kind}` |" in text
    assert f"The shades come from {levels.COLUMNS} columns" in text


@pytest.mark.parametrize(
    "words", ["colour", "azimuth", "RP3", "FLI", "MEGNO", "S2 x S1", "residue"]
)
def test_the_guide_finds_them(words):
    assert "dynamics" in {topic for topic, _, _ in guide.search(words)}
