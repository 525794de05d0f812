"""Times made where they are asked for are the exact ones, rounded once; a scene at other times."""

import pickle
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as some

import polhode
from polhode import BadInput, Scene
from polhode.numbers.conversion import ExactNumbers, spaced
from shared.tools import DOUBLE, EXTENDED, QUAD, even_times, exact_number

ENDS = [Fraction(1), Fraction(-7, 3), Fraction(1000), Fraction(10**30 + 1, 3), Fraction(1, 10**200)]


def exactly(end: Fraction, samples: int) -> tuple[Fraction, ...]:
    return tuple(end * Fraction(k, samples - 1) for k in range(samples))


@given(
    end=some.fractions(max_denominator=10**6).filter(bool) | some.sampled_from(ENDS),
    samples=some.integers(2, 400),
)
@example(end=Fraction(2**53 + 1, 7), samples=20_001)
@example(end=Fraction(781754121068286797, 731314540741666), samples=2001)  # k = 933
def test_doubles_of_even_times_are_rounded_once(end: Fraction, samples: int) -> None:
    true = [float(t) for t in exactly(end, samples)]
    assert even_times(end, samples).doubles().tolist() == true


@pytest.mark.parametrize("off", [0, Fraction(1, 2**60), -Fraction(1, 2**60)])
def test_ties_and_what_is_next_to_them_are_rounded_once(off: Fraction) -> None:
    """Next to a tie by less than a pair of doubles holds; the last one below a power of two."""
    for tie in (2**53 + 1, 2**53 + 3, 2**53 + 5, Fraction(2**54 - 1, 2)):
        end = (tie + off) * 32
        assert even_times(end, 33).doubles().tolist() == [float(t) for t in exactly(end, 33)]


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda x: x.name)
@pytest.mark.parametrize("end", [*ENDS, exact_number("sqrt(2)"), Fraction(10) ** 299], ids=str)
def test_rounded_times_are_those_of_the_number_type(end: Fraction, number: object) -> None:
    times = even_times(end, 9)
    rounded = times.rounded(number)  # type: ignore[arg-type]
    assert rounded == tuple(number.rounded(t) for t in times)  # type: ignore[attr-defined]
    assert rounded[3:5] == (rounded[3], rounded[4])
    assert rounded.rounded(number) == rounded  # type: ignore[arg-type]


TIMES = [
    np.array([0.25, 0.5]),
    np.array([0.1, 0.5], dtype=np.longdouble) / 3,
    (Fraction(1, 3), Fraction(2)),
]
KINDS = [even_times(Fraction(1), 4), *(polhode.load("euler/sphere").at(x).times for x in TIMES)]


@pytest.mark.parametrize("times", KINDS, ids=["even", "doubles", "longdoubles", "listed"])
def test_they_are_as_their_tuple(times: Any) -> None:
    numbers = tuple(times)
    assert times + (1,) == (*numbers, 1)  # noqa: RUF005
    assert (1,) + times == (1, *numbers)  # noqa: RUF005
    assert times + times == numbers * 2
    assert times == numbers == tuple(times[k] for k in range(len(times)))
    assert (times[-1], times[1:], repr(times), hash(times)) == (
        *(numbers[-1], numbers[1:]),
        *(repr(numbers), hash(numbers)),
    )
    back = pickle.loads(pickle.dumps(times))
    assert back == times
    assert (back.listed, back.ends) == (times.listed, times.ends)
    assert (back.floats is None) == (times.floats is None)
    with pytest.raises(IndexError):
        times[len(times)]


def test_an_array_is_taken_as_it_is_and_copied(scene: Scene) -> None:
    times = np.array([0.5, 1.0, 2.0])
    moved = scene.at(times)
    times[0] = 7
    assert moved.times == (Fraction(1, 2), 1, 2)
    assert scene.at(np.array([0, 1, 2])).times == (0, 1, 2)
    assert scene.at(moved.times[:0]).times == ()
    assert scene.at(np.ma.array([1.0, 2.0])).times == (1, 2)
    with pytest.raises(BadInput, match=r"at\[2\] = --: expected a number"):
        scene.at(np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0]))
    tiny = scene.at(["1e-400", 1]).output_times.rounded(DOUBLE)
    assert tiny[0] == DOUBLE.rounded(Fraction("1e-400")) > 0


WRONG = [
    ([1.0, 1.0], 2),
    ([1.0, 0.5], 2),
    ([0.0, 0.0], 2),
    ([-1.0, 1.0], 1),
    ([1.0, 2.0, 1.5], 3),
    ([0.0, -1.0, 1.0], 2),
    ([1.0, np.nan], 2),
    ([1.0, np.inf], 2),
]


@pytest.mark.parametrize(("times", "place"), WRONG)
@pytest.mark.parametrize("kind", [list, np.array])
def test_wrong_times_are_refused(scene: Scene, times: list[float], place: int, kind: type) -> None:
    with pytest.raises(BadInput, match=rf"at\[{place}\]"):
        scene.at(kind(times))


def test_numbers_spaced_from_another_one_than_zero() -> None:
    """They are equal where their numbers are: of one number the last is not in it."""
    assert spaced(Fraction(-1), Fraction(1), 3).misplaced() == 0
    assert spaced(Fraction(1), Fraction(2), 3).misplaced() is None
    assert even_times(Fraction(-2), 3).misplaced() is None
    assert spaced(Fraction(1), Fraction(2), 1) == spaced(Fraction(1), Fraction(3), 1) == (1,)
    assert spaced(Fraction(1), Fraction(2), 3) == (1, Fraction(3, 2), 2)
    for others in (spaced(Fraction(1), Fraction(3), 3), spaced(Fraction(1), Fraction(2), 2)):
        assert spaced(Fraction(1), Fraction(2), 3) != others
    uneven = ExactNumbers((Fraction(1), Fraction(5, 4), Fraction(2)))
    assert spaced(Fraction(1), Fraction(2), 3) != uneven != spaced(Fraction(1), Fraction(2), 3)


@pytest.fixture
def scene() -> Scene:
    return polhode.top(moments=[3, 2, 1], omega=[1, 1, 1])


def test_a_place_of_numpy_s_is_a_place() -> None:
    times = even_times(Fraction(0.1) * 8191, 100_001)
    time = times[np.int64(99_999)]  # once its product went over 2**63
    assert time == times[99_999] == times[np.int64(-2)]
    assert type(time.numerator) is int
    with pytest.raises(IndexError):
        times[100_001]


# -- A scene at other times: the same as one made with them, and what it keeps is shared -----------


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
    for x in fields(Scene):
        assert getattr(scene_at, x.name) == getattr(replaced, x.name)
    assert scene_at.text == replaced.text
    assert scene_at.end == Fraction(7, 3)
    assert scene_at.log10_angle == replaced.log10_angle
    assert scene_at.identity is scene.identity is not replaced.identity
    assert polhode.integrate(scene_at) == polhode.integrate(replaced)
