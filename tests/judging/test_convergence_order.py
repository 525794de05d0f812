"""The observed order of integrators whose order is known, and of broken ones."""

from __future__ import annotations

import numpy as np
import pytest

import polhode
from polhode import BadInput
from polhode.testing import order_of

SCENE = "kovalevskaya/generic"
F = polhode.field(SCENE)


def euler(f, y, h):
    return y + h * f(0, y)


def midpoint(f, y, h):
    return y + h * f(0, y + h / 2 * f(0, y))


def rk4(f, y, h, last=6.0):
    a = f(0, y)
    b = f(0, y + h / 2 * a)
    c = f(0, y + h / 2 * b)
    return y + h / last * (a + 2 * b + 2 * c + f(0, y + h * c))


def broken_rk4(f, y, h):
    return rk4(f, y, h, 6.006)


def with_step(method):
    def mine(h):
        y = np.array(F.start)
        for _ in range(round(2 / h)):
            y = method(F, y, h)
        return [y]

    return mine


@pytest.mark.parametrize(("method", "order"), [(euler, 1), (midpoint, 2), (rk4, 4)])
def test_the_order_of_a_method_is_seen(method, order):
    found = order_of(with_step(method), SCENE, at=[2])
    assert abs(found.order - order) < 0.15
    assert order - 0.3 < found.least <= found.order <= found.most < order + 0.3
    assert found.steps == tuple(2 / 2**k for k in range(5, 12))
    assert sum(found.counted) >= 4
    assert "between neighbours" in str(found)
    assert repr(found).startswith(f"<ObservedOrder {found.order:.2f}, ")


def test_a_wrong_weight_has_no_order():
    found = order_of(with_step(broken_rk4), SCENE, [0.02, 0.01, 0.005, 0.0025], at=[2])
    assert abs(found.order) < 0.5


def test_steps_at_which_rounding_rules_do_not_count():
    found = order_of(with_step(rk4), SCENE, [2 / 2**k for k in range(5, 14)], at=[2])
    assert not found.counted[-1]
    assert abs(found.order - 4) < 0.1


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ([0.1, 0.05], "3 or more, different"),
        ([0.1, 0.1, 0.1], "3 or more, different"),
        ([0.1, 0.05, -1], "3 or more, different"),
        ([0.1, "x", 1], "a number"),
        ([2, 1, 0.5], "that give 1.5 to 13"),
    ],
)
def test_steps_that_tell_no_order_are_refused(steps, expected):
    with pytest.raises(BadInput, match=expected):
        order_of(with_step(rk4), SCENE, steps, at=[2])


def test_what_is_no_function_or_no_time_is_refused():
    with pytest.raises(BadInput, match="a function from a step to rows"):
        order_of([1], SCENE)
    with pytest.raises(BadInput, match="a time other than 0"):
        order_of(with_step(rk4), SCENE, at=[0])
