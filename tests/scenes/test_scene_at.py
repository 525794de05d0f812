"""A scene at other times: the same as one made with them, and what it keeps is shared."""

from __future__ import annotations

from dataclasses import fields, replace
from fractions import Fraction

import pytest

import polhode
from polhode.scenes.scene import Scene


@pytest.mark.parametrize("case", ["published/nasa-brick", "kovalevskaya/generic"])
@pytest.mark.parametrize("used", [False, True])
def test_it_is_the_scene_made_with_those_times(case: str, used: bool) -> None:
    scene = polhode.load(case)
    if used:  # whatever a run leaves behind is no part of the other scene's times
        polhode.integrate(scene, at=[0.25])
        polhode.integrate(scene)
        scene.text, scene.integrals  # noqa: B018
    found = scene.at([1, "7/3"])
    made = replace(scene, times=(Fraction(1), Fraction(7, 3)))
    assert found == made
    assert [getattr(found, x.name) for x in fields(Scene)] == [
        getattr(made, x.name) for x in fields(Scene)
    ]
    assert found.text == made.text
    assert found.end == Fraction(7, 3)
    assert found.log10_angle == made.log10_angle
    assert found.identity is scene.identity is not made.identity
    assert polhode.integrate(found).states.tolist() == polhode.integrate(made).states.tolist()
