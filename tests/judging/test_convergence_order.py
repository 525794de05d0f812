"""The observed order of integrators whose order is known, and of broken ones."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput, testing
from polhode.cli import main
from shared.tables import euler, midpoint, rk4
from shared.tools import tiers

SCENE = "kovalevskaya/generic"
F = polhode.field(SCENE)


def with_step(method):
    def mine(h):
        y = np.array(F.start)
        for _ in range(round(2 / h)):
            y = method(F, y, h)
        return [y]

    return mine


@pytest.mark.parametrize(("method", "order"), tiers([(euler, 1), (midpoint, 2)], [(rk4, 4)]))
def test_the_order_of_a_method_is_seen(method, order):
    observed = testing.order_of(with_step(method), SCENE, [2 / 2**k for k in range(5, 11)], at=[2])
    assert abs(observed.order - order) < 0.15
    assert order - 0.3 < observed.least <= observed.order <= observed.most < order + 0.3
    assert sum(observed.counted) >= 4
    assert "between successive steps" in str(observed)
    assert repr(observed).startswith(f"<ObservedOrder {observed.order:.2f}, ")


def test_a_time_at_which_a_step_has_no_numbers_is_told():
    """It was left out of all steps, and nobody was told."""

    def mine(h):
        y, rows = np.array(F.start), []
        for _ in range(2):
            for _ in range(round(1 / h)):
                y = rk4(F, y, h)
            rows.append(y)
        return [rows[0], rows[1] * (np.nan if h > 0.1 else 1)]

    order = testing.order_of(mine, SCENE, [1 / 8, 1 / 16, 1 / 32, 1 / 64], at=[1, 2])
    assert np.isnan(order.digits).tolist() == [[False, True]] + 3 * [[False, False]]
    first, *others, last = str(order).splitlines()
    assert first.endswith(f"{order.digits[0][0]:.2f} digits, no numbers at 1 of 2 times")
    assert not any("no numbers" in line for line in others)
    assert "at 2 of 2 times" in last
    assert abs(order.order - 4) < 0.1


@pytest.mark.slow
def test_a_wrong_weight_has_no_order_and_steps_at_which_rounding_rules_do_not_count():
    broken = with_step(lambda f, y, h: rk4(f, y, h, 6.006))
    order = testing.order_of(broken, SCENE, [0.02, 0.01, 0.005, 0.0025], at=[2])
    assert abs(order.order) < 0.5
    order = testing.order_of(with_step(rk4), SCENE, [2 / 2**k for k in range(5, 14)], at=[2])
    assert not order.counted[-1]
    assert abs(order.order - 4) < 0.1


@pytest.mark.parametrize(
    ("method", "options", "expected"),
    [
        (rk4, {"steps": [0.1, 0.05]}, "3 or more, different"),
        (rk4, {"steps": [0.1, 0.1, 0.1]}, "3 or more, different"),
        (rk4, {"steps": [0.1, 0.05, -1]}, "3 or more, different"),
        (rk4, {"steps": [0.1, "x", 1]}, "a number"),
        (rk4, {"steps": [2, 1, 0.5]}, "that give 1.5 to 13"),
        (rk4, {"at": [0]}, "a time other than 0"),
        (None, {}, "a function from a step to rows"),
    ],
)
def test_what_tells_no_order_is_refused(method, options, expected):
    with pytest.raises(BadInput, match=expected):
        testing.order_of(method and with_step(method), SCENE, **({"at": [2]} | options))


def written(path, method, h, every=1, until=2.0, header="t,p,q,r,gamma1,gamma2,gamma3"):
    """A table of a method with steps h, each, or one in some."""
    y, rows = np.array(F.start), [[0.0, *F.start]]
    for k in range(round(until / h)):
        y = method(F, y, h)
        if (k + 1) % every == 0:
            rows.append([(k + 1) * h, *y])
    np.savetxt(path, rows, delimiter=",", fmt="%.17g", header=header, comments="")
    return str(path)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "order"), [(midpoint, 2), (rk4, 4)])
def test_the_order_between_two_files_is_told(method, order, tmp_path, capsys):
    coarse, fine = (written(tmp_path / f"{h}.csv", method, h) for h in (0.02, 0.01))
    assert main(["order", coarse, fine, SCENE]) == 0
    *table, output, second_line, last = capsys.readouterr().out.splitlines()
    assert not table
    number = float(last.split()[1].rstrip(";"))
    assert abs(number - order) < 0.15
    assert output.startswith("step 0.02 ")
    assert output.endswith("digits, 0.02.csv")
    assert second_line.endswith("digits, 0.01.csv")
    assert last.endswith("between successive steps at 100 of 100 times")


@pytest.mark.slow
def test_steps_may_be_told_and_three_files_given(tmp_path, capsys):
    files = [written(tmp_path / f"{n}.csv", rk4, 0.1 / n, 5 * n) for n in (1, 2, 4)]
    command = ["order", *files, SCENE]
    assert main(command) == 2
    assert "in --steps: the files' rows are 0.5, 0.5, 0.5 apart" in capsys.readouterr().err
    assert main([*command, "--steps", "1/10,0.05,0.025", "--json"]) == 0
    output = json.loads(capsys.readouterr().out)
    assert output["steps"] == [0.1, 0.05, 0.025]
    columns = output["columns"]
    assert columns["t"] == ["0.5", "1", "1.5", "2"]
    assert [*columns][2:] == ["correct_digits_1", "correct_digits_2", "correct_digits_3"]
    assert 3.8 < output["order_least"] <= output["order"] <= output["order_most"] < 4.2


def test_at_each_time_those_steps_count_that_neither_the_first_digit_nor_rounding_rules():
    digits = (1.0, 2.0), (2.0, 3.3), (3.0, 4.2), (4.0, 5.1), (4.1, 5.2)

    def order(most):
        limited = tuple(tuple(d >= most for d in row) for row in digits)
        steps = 16.0, 4.0, 1.0, 0.25, 0.0625
        return testing.ObservedOrder(steps, (Fraction(1), Fraction(2)), digits, limited)

    observed, wider = order(4.05), order(5.15)
    digit = math.log(10, 4)  # the order at which four times the step costs one
    assert observed.counted == (True, True, True, True, False)
    assert observed.orders == (pytest.approx(digit), None)  # of two steps alone
    assert (observed.order, observed.least, observed.most) == pytest.approx((digit,) * 3)
    assert wider.counted[-1]
    assert wider.least == pytest.approx(0.1 * digit)  # 4.0 to 4.1 digits
    assert wider.most == pytest.approx(1.3 * digit)
    assert wider.order == pytest.approx(sum(x for x in wider.orders) / 2)


def with_error(of_step):
    """A method whose error at t = 2 is known: the exact state, and something beside it."""
    (exact,) = polhode.reference(SCENE).at([2], 20)
    return lambda h: [[float(x) + of_step(h) for x in exact]]


#: Errors by the step, and how many of the seven steps 1/32 ... 1/2048 rounding limits.
ERRORS = {
    "rounding of each step": (lambda h: 3e-4 * h**4 + 3e-16 / h, 4),
    "rounding that comes back below the digits of a double": (
        lambda h: 3e-6 * h**4 + 2e-18 * h**-1.5,
        5,
    ),
    "none": (lambda h: 10 * h**4, 0),
    "another motion": (lambda h: h**4 + 1e-6, 0),
    "another motion, near": (lambda h: h**4 + 1e-9, 0),
}


@pytest.mark.parametrize("kind", ERRORS)
def test_steps_that_rounding_limits_are_left_out(kind):
    error, count = ERRORS[kind]
    steps = [2.0**-k for k in range(5, 12)]
    order = testing.order_of(with_error(error), SCENE, steps, at=[2])
    assert order.left_out == tuple(steps[len(steps) - count :])
    assert str(order).count(", left out: rounding limits it") == count
    assert abs(order.order - 4) < 0.2 or kind.startswith("another")
    assert order.order < 3.9 or not kind.startswith("another")


@pytest.mark.parametrize("steps", [[0.02, 0.01, 0.0005], [0.02, 0.01, 0.0005, 0.00025]])
def test_two_steps_tell_the_order_where_rounding_limits_the_others(steps):
    error, _ = ERRORS["rounding of each step"]
    order = testing.order_of(with_error(error), SCENE, steps, at=[2])
    assert order.counted == (True, True, *(False for _ in steps[2:]))
    assert abs(order.order - 4) < 0.1
    facts = {fact.name: fact.value for fact in order.facts()}
    assert facts["left_out"] == steps[2:]


def test_a_step_shorter_than_one_at_rounding_is_at_rounding():
    error, _ = ERRORS["rounding that comes back below the digits of a double"]
    with pytest.raises(
        BadInput, match=r"2 or more that give .*; rounding limits 0.00781, 0.000488"
    ):
        testing.order_of(with_error(error), SCENE, [2.0**-6, 2.0**-7, 2.0**-11], at=[2])


def test_files_that_rounding_limits_are_named(tmp_path, capsys):
    error, _ = ERRORS["rounding of each step"]
    steps, files = [0.02, 0.01, 0.0005], []
    for k, h in enumerate(steps):
        files.append(str(tmp_path / f"{k}.csv"))
        (row,) = with_error(error)(h)
        np.savetxt(
            *(files[-1], [[2.0, *row]]),
            **{"delimiter": ",", "header": "t,p,q,r,gamma1,gamma2,gamma3", "comments": ""},
            fmt="%.17g",
        )
    assert main(["order", *files, SCENE, "--steps", "0.02,0.01,0.0005"]) == 0
    *_, last, order = capsys.readouterr().out.splitlines()
    assert last.endswith(" digits, left out: rounding limits it, 2.csv")
    assert 3.9 < float(order.split()[1].rstrip(";")) < 4.1


@pytest.mark.parametrize("steps", ["0.1,0.1", "0.1"])
def test_orders_that_cannot_be_told_are_refused(steps, tmp_path, refusal):
    files = [written(tmp_path / f"{h}.csv", rk4, h) for h in (0.1, 0.05)]
    said = refusal("order", *files, SCENE, "--steps", steps)
    assert "2 different ones above 0, one a file" in said


@pytest.mark.slow
def test_files_at_rounding_have_no_order(tmp_path, refusal):
    files = [written(tmp_path / f"{h}.csv", rk4, h, 100) for h in (0.0005, 0.00025)]
    assert "2 or more that give 1.5 to" in refusal("order", *files, SCENE)
