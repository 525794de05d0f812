"""Numbers larger than a text may say are refused at once, of whatever kind, at every door."""

import sys
import time
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode

MOST_SECONDS = 0.3  # of the processor
GIVEN = {"moments": [2, 2, 1], "centre": [1, 0, 0], "weight": 1, "end": 1}
START = {"omega": ["0.3", 0.2, 1.1], "gamma": ["3/5", 0, "4/5"]}
SCENE = polhode.top(**GIVEN, **START)
FREE = polhode.Body.of_moments([1, 1, 1])
BALL = {"shape": "sphere", "mass": 1, "radius": 1}

GIANT = 10**999999
GIANTS = {
    "Decimal": Decimal("1e999999"),
    "Decimal, small": Decimal("1e-999999"),
    "Fraction": Fraction(GIANT),
    "Fraction, small": Fraction(1, GIANT),
    "int": GIANT,
    "mpf": mpmath.mpf("1e999999999"),
    "mpf, small": mpmath.mpf("1e-999999999"),
    "text": "1e999999",
    "power": "10**999999",
    "array": np.array(Decimal("1e999999"), dtype=object),
}
DOORS = {
    "moments": lambda x: polhode.top(**GIVEN | {"moments": [2, 2, x]}, **START),
    "inertia": lambda x: polhode.top(inertia=[[2, 0, 0], [0, 2, 0], [0, 0, x]], **START),
    "centre": lambda x: polhode.top(**GIVEN | {"centre": [1, 0, x]}, **START),
    "weight": lambda x: polhode.top(**GIVEN | {"weight": x}, **START),
    "omega": lambda x: polhode.top(**GIVEN, **START | {"omega": [0, 0.5, x]}),
    "gamma": lambda x: polhode.top(**GIVEN, **START | {"gamma": [0.6, 0.8, x]}),
    "quaternion": lambda x: polhode.top(**GIVEN, omega=[0, 0, 1], quaternion=[0.5, 0, 0, x]),
    "angles": lambda x: polhode.top(**GIVEN, angles=[0, x, 0], rates=[0, 0, 1]),
    "h": lambda x: polhode.top(**GIVEN, gamma=[0, 0, 1], h=x, f=1),
    "end": lambda x: polhode.top(**GIVEN | {"end": x}, **START),
    "part": lambda x: polhode.Part("sphere", mass=x, radius=1),
    "part in a scene": lambda x: polhode.top(parts=[BALL | {"radius": x}], g=1, **START),
    "Body": lambda x: polhode.Body.of_moments([1, 1, x]),
    "Scene": lambda x: polhode.Scene(FREE, (0, 0, x), (0, 0, 1)),
    "psi": lambda x: polhode.Scene(FREE, (0, 0, 1), (0, 0, 1), psi=x),
    "at": lambda x: polhode.integrate(SCENE, at=[x]),
    "tol": lambda x: polhode.integrate(SCENE, tol=x),
    "digits": lambda x: polhode.integrate(SCENE, digits=x),
    "vary": lambda x: polhode.integrate_many(SCENE, {"start.omega[1]": [x]}, at=[1]),
    "members": lambda x: polhode.integrate_many(SCENE, [{"start.omega[1]": x}], at=[1]),
    "reference": lambda x: polhode.reference(SCENE).at([x], 20),
    "certify": lambda x: polhode.certify(SCENE, at=[x]),
    "table": lambda x: polhode.compare({"t": [1], "p": [x]}, SCENE),
    "rows": lambda x: polhode.compare([[1, 1, 1, 0, 0, x]], SCENE, at=[1]),
    "section": lambda x: polhode.section(SCENE, h=x, f=1),
    "period": lambda x: polhode.orbit(SCENE, period=x),
}


@pytest.fixture(params=[0, 4300])
def _limit_of_python(request):
    """Python's own limit of digits, which a program may lift."""
    before = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(request.param)
    yield
    sys.set_int_max_str_digits(before)


@pytest.mark.usefixtures("_limit_of_python")
@pytest.mark.parametrize("door", DOORS)
def test_a_number_that_is_too_large_is_refused_at_once(door):
    for kind, giant in GIANTS.items():
        most = MOST_SECONDS if kind != "Decimal" else 10 * MOST_SECONDS  # the first imports
        seconds = []
        while not seconds or (
            seconds[-1] >= most and len(seconds) < 3
        ):  # garbage is collected at times
            began = time.process_time()
            with pytest.raises(polhode.BadInput) as fault:
                DOORS[door](giant)
            seconds.append(time.process_time() - began)
        assert min(seconds) < most, kind
        assert len(str(fault.value)) < 400
        assert "TOML" not in str(fault.value), "none speaks of a file where none was given"


@pytest.mark.parametrize("giant", [Decimal("1e5000"), "1e5000", Decimal("1e-5000")])
def test_a_decimal_of_any_kind_is_told_the_limit_of_texts(giant):
    said = "a decimal has at most 4000 digits and an exponent from -4000 to 4000"
    for door in ("moments", "omega", "end", "part", "Body", "at", "vary", "section"):
        with pytest.raises(polhode.BadInput, match=said):
            DOORS[door](giant)


def test_numbers_up_to_the_limit_are_exact():
    for number in (Decimal("1e4000"), 10**4000, Fraction(10) ** 4000, "1e4000"):
        assert polhode.top(moments=[1, 1, 1], omega=[0, 0, number]).omega[2] == 10**4000
    tiny = Decimal("-1e-4000")
    assert polhode.top(moments=[1, 1, 1], omega=[0, 0, tiny]).omega[2] == Fraction(-1, 10**4000)


def test_a_gate_of_any_number_of_digits_is_a_gate():
    with pytest.raises(AssertionError, match="at least inf are wanted"):
        polhode.testing.assert_digits(polhode.integrate(SCENE), SCENE, 10**5000)
