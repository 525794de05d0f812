"""Motions of Lagrange tops, one or more of every regime, and what their tests share."""

import functools
from fractions import Fraction

from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers.mpmath_context import mpmath
from shared.closed_form_checks import fractions, number

F = Fraction
PSI = F(7, 10)


def small(digits):
    return F(1, 10**digits)


def tilted(x, side=1):
    """A vertical at an angle of about 2x to the axis of symmetry, exactly of length 1."""
    n = 1 + x * x
    return (F(0), 2 * x / n, side * (1 - x * x) / n)


GAMMA = (F(9, 25), F(12, 25), F(4, 5))
TILT = (F(4, 5), F(0), F(3, 5))
UP, DOWN = (0, 0, 1), (0, 0, -1)

#: name: moments, torque Mg r0, omega, gamma, regime.
MOTIONS = {
    "rest upright": ((1, 1, "0.5"), (0, 0, 1), (0, 0, 0), UP, "rest, upright"),
    "rest hanging": ((1, 1, "0.5"), (0, 0, -2), (0, 0, 0), UP, "rest, hanging"),
    "sleeping, stable": ((1, 1, "0.8"), (0, 0, 1), (0, 0, 4), UP, "sleeping, stable"),
    "sleeping, unstable": ((1, 1, "0.8"), (0, 0, 1), (0, 0, -1), UP, "sleeping, unstable"),
    "critical spin": ((1, 1, 1), (0, 0, 1), (0, 0, 2), UP, "sleeping, critical spin"),
    "hanging": ((1, 1, "0.5"), (0, 0, 1), (0, 0, "1.5"), DOWN, "hanging"),
    # u0 W^2 - n W + a/2 = 0 with n = 8/5, a = 2, u0 = 3/5 has the roots 1 and 5/3.
    "steady slow": ((1, 1, "0.5"), (0, 0, 1), ("0.8", 0, "3.2"), TILT, "steady precession, slow"),
    "steady fast": ((1, 1, "0.5"), (0, 0, 1), ("4/3", 0, "3.2"), TILT, "steady precession, fast"),
    "steady double": ((1, 1, "0.5"), (0, 0, "0.6"), ("0.8", 0, "2.4"), TILT, "steady precession"),
    "steady level": (
        (1, 1, "0.5"),
        (0, 0, 1),
        ("0.625", 0, "3.2"),
        (1, 0, 0),
        "steady precession",
    ),
    "homoclinic": ((1, 1, "0.8"), (0, 0, 5), (2, 0, 5), TILT, "homoclinic to the sleeping top"),
    "cusped": ((1, 1, "0.5"), (0, 0, 1), (0, 0, "2.5"), ("0.6", 0, "0.8"), "cusped"),
    "cusp to come": (
        (1, 1, 1),
        (0, 0, "0.5"),
        ("0.6", 0, "1.2"),
        (-F(3, 5), 0, F(4, 5)),
        "looping",
    ),
    "looping": ((1, 1, "1.4"), (0, 0, 1), ("-0.3", "0.5", "1.5"), GAMMA, "looping"),
    "nutation": ((1, 1, "0.7"), (0, 0, "1.3"), ("0.3", "0.4", "1.5"), GAMMA, "nutation"),
    "upper pole": (
        (1, 1, "0.8"),
        (0, 0, "0.5"),
        ("0.4", "1.1", 1),
        TILT,
        "through the upper pole",
    ),
    "lower pole": (
        (1, 1, "0.8"),
        (0, 0, "-0.5"),
        ("0.4", "1.1", 1),
        TILT,
        "through the lower pole",
    ),
    "from the upper pole": ((1, 1, 2), (0, 0, 1), (1, "0.5", 1), UP, "through the upper pole"),
    "from the lower pole": ((1, 1, 2), (0, 0, 1), (1, "0.5", 1), DOWN, "through the lower pole"),
    "spherical pendulum": ((1, 1, "0.8"), (0, 0, 1), ("0.5", 1, 0), TILT, "spherical pendulum"),
    "conical": (
        (1, 1, 2),
        (0, 0, "0.6"),
        ("0.8", 0, 0),
        ("0.8", 0, "-0.6"),
        "spherical pendulum, conical",
    ),
    "librating": ((1, 1, "0.8"), (0, 0, 1), (0, "0.5", 0), TILT, "planar pendulum, librating"),
    "rotating": ((1, 1, "0.8"), (0, 0, 1), (0, 3, 0), DOWN, "planar pendulum, rotating"),
    "separatrix": ((1, 1, "0.8"), (0, 0, 1), (0, 2, 0), DOWN, "planar pendulum, separatrix"),
    "fast": ((1, 1, "0.5"), (0, 0, 1), ("0.5", 0, 10**6), ("0.6", 0, "0.8"), "looping"),
    "needle": ((1, 1, small(6)), (0, 0, 1), ("0.5", "0.2", 7), GAMMA, "nutation"),
    "weak": ((1, 1, "0.5"), (0, 0, small(60)), ("0.5", 1, 1), GAMMA, "nutation"),
    "near cusp 1e-15": (
        (1, 1, "0.5"),
        (0, 0, 1),
        (0, small(15), "2.5"),
        ("0.6", 0, "0.8"),
        "looping",
    ),
    "near pole 1e-12": (
        (1, 1, "0.8"),
        (0, 0, "0.5"),
        (F(2, 5) + small(12), "1.1", 1),
        TILT,
        "nutation",
    ),
    "next to the pole 1e-30": (
        (1, 1, "0.8"),
        (0, 0, "0.5"),
        ("0.4", "1.1", 1),
        tilted(small(30), -1),
        "looping",
    ),
    "near homoclinic 1e-20": (
        (1, 1, "0.8"),
        (0, 0, 5),
        (2, 0, 5 + small(20)),
        TILT,
        "looping",
    ),
    "near homoclinic 1e-100": (
        (1, 1, "0.8"),
        (0, 0, 5),
        (2, small(100), 5),
        TILT,
        "through the upper pole",
    ),
    "near steady 1e-8": (
        (1, 1, "0.5"),
        (0, 0, 1),
        (F(4, 5) + small(8), 0, "3.2"),
        TILT,
        "nutation",
    ),
    "near steady 1e-60": (
        (1, 1, "0.5"),
        (0, 0, 1),
        ("0.8", small(60), "3.2"),
        TILT,
        "nutation",
    ),
    "unstable sleeper leaving": (
        (1, 1, "0.8"),
        (0, 0, 1),
        (small(9), 0, 1),
        UP,
        "through the upper pole",
    ),
    "critical spin + 1e-10": (
        (1, 1, 1),
        (0, 0, 1),
        (small(10), 0, 2 + small(10)),
        UP,
        "through the upper pole",
    ),
    "critical spin - 1e-10": (
        (1, 1, 1),
        (0, 0, 1),
        (small(30), 0, 2 - small(10)),
        tilted(small(20)),
        "looping",
    ),
    "almost hanging 1e-60": (
        (1, 1, "0.5"),
        (0, 0, 1),
        (small(60), 0, "3.2"),
        tilted(small(60), -1),
        "looping",
    ),
    "first axis": (("0.7", 1, 1), ("-1.3", 0, 0), ("1.5", "0.3", "0.4"), GAMMA, "looping"),
    "second axis": ((1, "0.7", 1), (0, "1.3", 0), ("0.3", "1.5", "0.4"), GAMMA, "nutation"),
    "sphere": ((1, 1, 1), ("0.5", "-0.7", "1.1"), ("0.3", "-0.7", "1.1"), GAMMA, "looping"),
}
CONSTANT = [name for name in MOTIONS if MOTIONS[name][4].startswith("rest")]


def motion(name):
    return tuple(fractions(row) for row in MOTIONS[name][:4])


@functools.cache
def top_of(name, psi=PSI):
    """One motion for all tests that ask for it: its constants are made once."""
    return LagrangeTop(*motion(name), psi)


def speed(name):
    """A lower bound of the largest |w| on the way."""
    _, torque, omega, _ = motion(name)
    with mpmath.workdps(150):
        pendulum = mpmath.sqrt(max(abs(number(x)) for x in torque))
        return max([abs(number(x)) for x in omega]) or pendulum / 100
