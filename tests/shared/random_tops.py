"""Random starts of every family with a closed form, the hard ones among them.

From rest and near it, fast, about one axis or nearly, next to separatrices, degenerate curves,
permanent rotations and poles, by 1e-1 to 1e-30.  A start is moments, Mg r0, omega, gamma, all
rational (Hess's: roots), in principal axes; numbers are of order 1.
"""

from fractions import Fraction
from random import Random

import test_bobylev_steklov
import test_chaplygin
import test_goryachev
import test_goryachev_chaplygin
import test_goryachev_chaplygin_approach
import test_grioli
import test_hess
import test_kovalevskaya
import test_n_kowalewski
import test_steklov

from shared.closed_form_checks import fractions

F = Fraction
ZERO = F(0), F(0), F(0)
HOW = "any", "rest", "near rest", "fast", "one axis", "nearly one axis"
POWERS = 1, 2, 3, 6, 9, 15, 20, 30
#: Of the centre of mass in the plane across the third axis.
DIRECTIONS = (F(1), F(0)), (F(3, 5), F(4, 5)), (F(-105, 233), F(208, 233)), (F(0), F(-1))


def ratio(pick, most=30):
    """A number between -most and most."""
    return F(pick.randint(-most, most), pick.randint(1, 12))


def tiny(pick):
    """A small number of either sign."""
    return pick.choice((1, -1, 2, -3)) * F(1, 10 ** pick.choice(POWERS))


def turned(pick, v, size):
    """A vector, turned by about ``size``."""
    a, (b, c, d) = F(1), (size * pick.randint(-3, 3) for _ in range(3))
    x, y, z = v
    square = a * a + b * b + c * c + d * d
    return (
        ((a * a + b * b - c * c - d * d) * x + 2 * (b * c - a * d) * y + 2 * (b * d + a * c) * z)
        / square,
        (2 * (b * c + a * d) * x + (a * a - b * b + c * c - d * d) * y + 2 * (c * d - a * b) * z)
        / square,
        (2 * (b * d - a * c) * x + 2 * (c * d + a * b) * y + (a * a - b * b - c * c + d * d) * z)
        / square,
    )


def vertical(pick):
    """gamma in any direction."""
    return turned(pick, (F(0), F(0), F(1)), F(1, pick.randint(1, 3)))


def omega(pick, how):
    """omega of a kind."""
    w = [ratio(pick) / 6 for _ in range(3)]
    if how == "rest":
        return ZERO
    if how in ("fast", "near rest"):
        factor = 50 if how == "fast" else abs(tiny(pick))
        return tuple(factor * x for x in w)
    if how in ("one axis", "nearly one axis"):
        axis, rest = pick.randrange(3), tiny(pick) if how == "nearly one axis" else 0
        return tuple(x if i == axis else rest * x for i, x in enumerate(w))
    return tuple(w)


def moments(pick):
    """Of a body; two or three may be nearly equal, one may be small."""
    x, y, z = (F(pick.randint(1, 40), pick.randint(1, 9)) for _ in range(3))
    kind = pick.choice(("any", "nearly symmetric", "sphere", "needle"))
    if kind == "nearly symmetric":
        y = x * (1 + tiny(pick))
    if kind == "sphere":
        y, z = x, x * (1 + tiny(pick))
    if kind == "needle":
        x, y = x * abs(tiny(pick)), y * abs(tiny(pick))
    return x + y, y + z, z + x


def euler(pick):
    """No torque."""
    return moments(pick), ZERO, omega(pick, pick.choice(HOW)), vertical(pick)


def lagrange(pick):
    """Upright, hanging and cusped ones among them, nearly or quite."""
    A, up = F(pick.randint(1, 40), pick.randint(1, 9)), vertical(pick)
    w, kind = omega(pick, pick.choice(HOW)), pick.choice(("any", "any", "upright", "cusp"))
    if kind == "upright":
        up = turned(pick, (F(0), F(0), F(pick.choice((1, -1)))), tiny(pick))
    if kind == "cusp":
        w = pick.choice((F(0), tiny(pick))), F(0), ratio(pick)
    torque = F(0), F(0), pick.choice((1, -1)) * F(pick.randint(1, 30), 7)
    return (A, A, A * F(pick.randint(1, 19), 10)), torque, w, up


def pendulum(pick):
    """Swings, also of any size next to hanging, upright and the separatrix."""
    tangent = pick.choice((ratio(pick), tiny(pick), 1 / tiny(pick)))
    over, rate = 1 + tangent * tangent, pick.choice((F(0), ratio(pick) / 3, tiny(pick)))
    up = 2 * tangent / over, (1 - tangent * tangent) / over, F(0)
    torque = F(pick.randint(1, 9), 4), ratio(pick, 9), F(0)
    x, y, z = (F(pick.randint(1, 20), 3) for _ in range(3))
    return (x + y, y + z, z + x), torque, (F(0), F(0), rate), up


def staude(pick):
    """Mg r0 = om^2 I gamma - mu gamma."""
    A, up = moments(pick), vertical(pick)
    om, mu = pick.choice((ratio(pick) / 3, tiny(pick))), ratio(pick)
    torque = tuple(om * om * x * y - mu * y for x, y in zip(A, up, strict=True))
    return A, torque, tuple(om * x for x in up), up


def kovalevskaya(pick):
    """Any start, or one next to a motion on a degenerate curve."""
    if pick.random() < 0.5:
        C, weight = F(pick.randint(1, 9), pick.randint(1, 9)), F(pick.randint(1, 9), 4)
        torque = *(weight * x for x in pick.choice(DIRECTIONS)), F(0)
        return (2 * C, 2 * C, C), torque, omega(pick, pick.choice(HOW)), vertical(pick)
    known = test_kovalevskaya.SPECIAL | test_kovalevskaya.DEGENERATE
    w, up = map(fractions, known[pick.choice(sorted(known))][:2])
    if pick.random() < 0.3:  # Bobylev and Steklov's: q = 0, gamma3 = p r
        up, r = vertical(pick), pick.choice((1, -1)) * F(pick.randint(1, 250), 6)
        w = up[2] / r, F(0), r
    size, kept = tiny(pick), pick.randrange(3)
    if kept != 1:
        up = turned(pick, up, size)
    if kept != 2:
        w = tuple(x + size * pick.randint(-3, 3) for x in w)
    return test_kovalevskaya.BODY, test_kovalevskaya.TORQUE, w, up


def goryachev_chaplygin(pick):
    """f = 0: any, asymptotic, next to those of one frequency, near rest."""
    kind = pick.choice(("any", "asymptotic", "near", "near rest", "rest", "fast"))
    if kind == "any":
        return test_goryachev_chaplygin.random_member(pick.randrange(10**6))
    if kind == "asymptotic":
        return test_goryachev_chaplygin_approach.asymptotic(pick.randrange(10**6))
    if kind == "near":
        near = test_goryachev_chaplygin.NEAR[pick.choice(sorted(test_goryachev_chaplygin.NEAR))]
        return test_goryachev_chaplygin.place(near(abs(tiny(pick))))
    up = vertical(pick)
    while not up[2]:
        up = vertical(pick)
    p, q = ratio(pick) / 7, ratio(pick) / 7
    size = {"near rest": tiny(pick), "rest": F(0), "fast": F(40)}[kind]
    w = size * p, size * q, -4 * size * (p * up[0] + q * up[1]) / up[2]
    weight = F(pick.randint(1, 9), pick.randint(1, 9))
    torque = *(weight * x for x in pick.choice(DIRECTIONS)), F(0)
    return test_goryachev_chaplygin.BODY, torque, w, up


def hess(pick):
    """Irrational in general."""
    return test_hess.random_member(pick.randrange(10**6))


FAMILIES = {
    "euler": euler,
    "lagrange": lagrange,
    "kovalevskaya": kovalevskaya,
    "pendulum": pendulum,
    "staude": staude,
    "bobylev-steklov": test_bobylev_steklov.member,
    "grioli": test_grioli.member,
    "goryachev-chaplygin": goryachev_chaplygin,
    "hess": hess,
    "steklov": test_steklov.member,
    "goryachev": test_goryachev.member,
    "n-kowalewski": test_n_kowalewski.member,
    "chaplygin": test_chaplygin.member,
}


def start(family, seed):
    """A start of a family, and the generator that made it."""
    pick = Random(f"{family} {seed}")
    return FAMILIES[family](pick), pick
