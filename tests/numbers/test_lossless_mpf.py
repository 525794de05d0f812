"""Numbers that leave polhode keep all bits in copies, pickles and other processes."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import mpmath
import numpy as np
import pytest

import polhode
from polhode.numbers import mpmath_context
from shared.tools import tiers


def numbers(value: Any) -> Iterator[Any]:
    """The mpf and mpc in nested values."""
    if hasattr(value, "_mpf_") or hasattr(value, "_mpc_"):
        yield value
    elif isinstance(value, dict):
        yield from numbers(list(value.values()))
    elif isinstance(value, (list, tuple, np.ndarray)):
        for x in value:
            yield from numbers(x)


def raw(value: Any) -> list[Any]:
    return [getattr(x, "_mpf_", None) or x._mpc_ for x in numbers(value)]


def answers() -> dict[str, Callable[[], Any]]:
    top, at = "lagrange/nutation", [0, 1]
    scene = polhode.load(top)
    return {
        "rows": lambda: polhode.reference(top).at(at, 50),
        "attitude": lambda: polhode.reference(top).attitude(at, 40),
        "angles": lambda: polhode.reference(top).angles(at, 40),
        "frequencies": lambda: polhode.reference(top).frequencies,
        "curve": lambda: polhode.reference("kovalevskaya/generic").curve,
        "quad": lambda: polhode.integrate(scene, "quad", at=at).states,
        "dense": lambda: polhode.integrate(scene, "quad", at=at)([0.5]),
        "mp": lambda: polhode.integrate(scene, "mp", digits=45, at=at).states,
        "sweep": lambda: (
            polhode.integrate_many(scene, {"start.omega[1]": [1, 2]}, number="quad", at=at).states
        ),
        "certified": lambda: polhode.certify("general/asymmetric-regular", at=[1]).midpoints,
        "enclosure": lambda: polhode.reference("general/asymmetric-regular").at([1], 30),
        "orbit": lambda: (lambda result: [result.multipliers, result.residue, result.period])(
            polhode.orbit("grioli/precession", digits=40)
        ),
    }


@pytest.mark.parametrize(
    "name",
    tiers(
        [*("rows", "attitude", "frequencies", "dense", "mp", "certified")],
        ["angles", "curve", "sweep", "orbit"],
    ),
)
def test_copies_of_an_answer_are_it_to_the_bit(name):
    answer = answers()[name]()
    bits = raw(answer)
    assert max(x.bit_length() for number in bits for x in np.ravel(number).tolist()) > 53
    ways = [
        copy.copy,
        copy.deepcopy,
        *(lambda x, k=k: pickle.loads(pickle.dumps(x, k)) for k in range(6)),
    ]
    for copied in ways:
        again = copied(answer)
        assert raw(again) == bits
        assert raw([copied(x) for x in numbers(again)]) == bits  # and of copies
        assert {*map(type, numbers(again))} == {*map(type, numbers(answer))}


def test_parts_of_a_complex_number_keep_their_bits():
    third = mpmath_context.mpmath
    with third.workprec(200):
        z = mpmath_context.ordinary(third.mpc(1, 2) / 3)
    for x in (z.real, z.imag, z):
        assert raw(pickle.loads(pickle.dumps(x))) == raw(x)
    assert z.imag == 2 * z.real
    assert repr(z).startswith("mpc(real='0.33333")  # as mpmath writes it; it named a class of ours


def test_they_are_mpmath_s_numbers_in_all_else():
    (row,) = polhode.reference("lagrange/nutation").at([1], 50)
    x = row[0]
    plain = mpmath.mp.make_mpf(x._mpf_)
    assert isinstance(x, mpmath.mpf)
    assert (hash(x), repr(x), str(x), float(x)) == (hash(plain), repr(plain), str(plain), float(x))
    assert x == plain
    assert mpmath.nstr(x, 40) == mpmath.nstr(plain, 40)
    for bits in (20, 53, 400):
        with mpmath.workprec(bits):
            assert (mpmath.mpf(x)._mpf_, (+x)._mpf_) == (mpmath.mpf(plain)._mpf_, (+plain)._mpf_)
            for f in (mpmath.sqrt, mpmath.exp, abs, mpmath.mp.convert, lambda y: y**3):
                assert (type(f(x)), f(x)) == (mpmath.mpf, f(plain))
            assert (x - row[1])._mpf_ == (plain - row[1])._mpf_
            assert mpmath.matrix([row])[0, 0]._mpf_ == plain._mpf_
            assert mpmath.fsum(row) == mpmath.fsum(map(mpmath.mp.convert, row))
    assert x in mpmath.iv.mpf([x, x])


def test_what_is_computed_from_a_pickled_sweep_is_the_same():
    """A body's own axes were not recognised in its copy: the copy's drift had other digits."""
    many = polhode.integrate_many(
        "general/asymmetric-regular", {"start.omega[1]": [1, 2, 3]}, at=[0, 1, 2]
    )
    again = pickle.loads(pickle.dumps(many))
    assert again.members.scene.body.axes.trivial
    assert np.array_equal(many.drift, again.drift, equal_nan=True)
    assert again.drift is not many.drift
    for k in range(3):
        assert again[k].drift == many[k].drift
        assert again[k].expected == many[k].expected
