"""A scene at other times: the same as one made with them, and what it keeps is shared."""

from __future__ import annotations

from dataclasses import fields, replace
from fractions import Fraction

import pytest

import polhode
from polhode import Scene


@pytest.mark.parametrize("case", ["published/nasa-brick", "kovalevskaya/generic"])
@pytest.mark.parametrize("used", [False, True])
def test_it_is_the_scene_made_with_those_times(case: str, used: bool) -> None:
    scene = polhode.load(case)
    if used:  # whatever a run leaves behind is no part of the other scene's times
        polhode.integrate(scene, at=[0.25])
        polhode.integrate(scene)
        scene.text, scene.integrals  # noqa: B018
    scene_at = scene.at([1, "7/3"])
    replaced = replace(scene, times=(Fraction(1), Fraction(7, 3)))
    assert scene_at == replaced
    assert [getattr(scene_at, x.name) for x in fields(Scene)] == [
        getattr(replaced, x.name) for x in fields(Scene)
    ]
    assert scene_at.text == replaced.text
    assert scene_at.end == Fraction(7, 3)
    assert scene_at.log10_angle == replaced.log10_angle
    assert scene_at.identity is scene.identity is not replaced.identity
    assert (
        polhode.integrate(scene_at).states.tolist() == polhode.integrate(replaced).states.tolist()
    )
