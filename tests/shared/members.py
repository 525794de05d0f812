"""Random starts of every family with a closed form, the hard ones among them.

From rest and near it, fast, about one axis or nearly, next to separatrices, degenerate curves,
permanent rotations and poles, by 1e-1 to 1e-30.  A start is moments, Mg r0, omega, gamma, exact, in
principal axes; numbers are of order 1.
"""

import tomllib
from fractions import Fraction
from pathlib import Path
from random import Random

from polhode.numbers import exact
from polhode.numbers.expression import number
from shared import orbit_members
from shared.orbit_members import draw_until_real

F = Fraction
ZERO = F(0), F(0), F(0)
HOW = "any", "rest", "near rest", "fast", "one axis", "nearly one axis"
POWERS = 1, 2, 3, 6, 9, 15, 20, 30
#: Of the centre of mass in the plane across the third axis.
DIRECTIONS = (F(1), F(0)), (F(3, 5), F(4, 5)), (F(-105, 233), F(208, 233)), (F(0), F(-1))


def motion_table() -> dict[str, dict[str, list[str]]]:
    """The motions of tests/data/motions.toml, as they are written there."""
    path = Path(__file__).parents[1] / "data" / "motions.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def read_start(texts):
    """A start as it is written."""
    return tuple(tuple(map(number, text.split())) for text in texts[:4])


def ratio(pick, most=30):
    """A number between -most and most."""
    return F(pick.randint(-most, most), pick.randint(1, 12))


def tiny(pick):
    """A small number of either sign."""
    return pick.choice((1, -1, 2, -3)) * F(1, 10 ** pick.choice(POWERS))


def rotation(a, b, c, d):
    """The matrix of a quaternion of any length, by rows."""
    n = F(1) * (a * a + b * b + c * c + d * d)
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return tuple(tuple(x / n for x in row) for row in rows)


def rotated_vector(pick, v, size):
    """A vector, turned by about ``size``."""
    rows = rotation(F(1), *(size * pick.randint(-3, 3) for _ in range(3)))
    return tuple(sum(x * y for x, y in zip(row, v, strict=True)) for row in rows)


def vertical(pick):
    """gamma in any direction."""
    return rotated_vector(pick, (F(0), F(0), F(1)), F(1, pick.randint(1, 3)))


def rates(pick, how):
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
    """No torque; a fourth of them on the separatrix, where the moments differ."""
    A, w = moments(pick), rates(pick, pick.choice(HOW))
    if pick.random() < 0.25 and any(w):
        low, middle, high = sorted(range(3), key=lambda i: A[i])
        if A[low] < A[middle] < A[high]:
            a, b, c = (A[i] for i in (low, middle, high))
            w = list(w)
            w[high] = w[low] * exact.sqrt(a * (b - a) / (c * (c - b)))
    return A, ZERO, tuple(w), vertical(pick)


def lagrange(pick):
    """Upright, hanging and cusped ones among them, nearly or quite."""
    A, up = F(pick.randint(1, 40), pick.randint(1, 9)), vertical(pick)
    w, kind = rates(pick, pick.choice(HOW)), pick.choice(("any", "any", "upright", "cusp"))
    if kind == "upright":
        up = rotated_vector(pick, (F(0), F(0), F(pick.choice((1, -1)))), tiny(pick))
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
        return (2 * C, 2 * C, C), torque, rates(pick, pick.choice(HOW)), vertical(pick)
    motions = motion_table()["kovalevskaya"].values()
    near = [texts for texts in motions if texts[1] == "1 0 0" and "e-" not in "".join(texts[2:4])]
    body, torque, w, up = read_start(pick.choice(near))
    if pick.random() < 0.3:  # Bobylev and Steklov's: q = 0, gamma3 = p r
        up, r = vertical(pick), pick.choice((1, -1)) * F(pick.randint(1, 250), 6)
        w = up[2] / r, F(0), r
    size, fixed = tiny(pick), pick.randrange(3)
    if fixed != 1:
        up = rotated_vector(pick, up, size)
    if fixed != 2:
        w = tuple(x + size * pick.randint(-3, 3) for x in w)
    return body, torque, w, up


#: Of Goryachev and Chaplygin's case.
BODY = F(4), F(4), F(1)


def tangent(t):
    """(sin, cos) of an angle by a rational parameter."""
    return 2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)


def half(cos2, side=1):
    """(sin, cos) of an angle with that square of its cosine."""
    return side * exact.sqrt(1 - cos2), exact.sqrt(cos2)


def with_f_0(u, v, a, xi, et, sg=1):
    """u, v > 0 and (sin, cos) of xi/2 and et/2 make a start with f = 0."""
    (sx, cx), (se, ce) = xi, et
    root, total = exact.sqrt(u * v), u + v
    omega = (sg * root * (se * cx - ce * sx) / 2, sg * root * (cx * ce + sx * se) / 2, u - v)
    gamma = (
        -(u * (cx * cx - sx * sx) + v * (ce * ce - se * se)) / total,
        -2 * (u * sx * cx - v * se * ce) / total,
        2 * sg * root * (sx * ce + cx * se) / total,
    )
    return BODY, (a, F(0), F(0)), omega, gamma


def on_cubics(u, v, a, H, G, signs=(1, 1)):
    """One with given constants: cos^2 of the halves from the cubics."""
    below = H - 2 * a
    xi = half((u * u - below - 4 * G / u) / (4 * a), signs[0])
    et = half((v * v - below + 4 * G / v) / (4 * a), signs[1])
    return with_f_0(u, v, a, xi, et)


#: Next to a motion of one frequency, or one that tends to it, by a gap.
NEAR = {
    "D- from above": lambda gap: on_cubics(F(9, 4), F(3, 4), F(2), F(7) + gap, F(1, 2)),
    "D- from below": lambda gap: on_cubics(F(9, 4), F(3, 4), F(2), F(7) - gap, F(1, 2)),
    "D+": lambda gap: on_cubics(F(3, 2), F(1), F(1), F(1) + gap, F(1, 2)),
    "G, librating": lambda gap: on_cubics(F(5, 4), F(2, 3), F(1), F(1), gap),
    "G, rotating": lambda gap: on_cubics(F(3, 2), F(5, 4), F(1), F(3), gap),
}
#: By more or by other numbers, which none is drawn from.
NEARER = NEAR | {
    "separatrix": lambda gap: on_cubics(F(3, 2), F(5, 4), F(1), F(2), gap),
    "separatrix, H": lambda gap: on_cubics(F(3, 2), F(5, 4), F(1), F(2) + gap, gap),
    "D+": lambda gap: on_cubics(F(3, 2), 1 + gap / 4, F(1), F(1) + gap * gap, F(1, 2)),
}
#: At a turning point of u, and G = 0 with both halves of the angles of either sign.
EXCEPTIONAL = {
    "u at its largest": on_cubics(F(2), F(1), F(1), F(3, 2), F(1, 4)),
    "librating": on_cubics(F(5, 4), F(2, 3), F(1), F(1), F(0), (-1, 1)),
    "rotating": on_cubics(F(3, 2), F(5, 4), F(1), F(3), F(0), (-1, 1)),
    "rotating back": on_cubics(F(3, 2), F(5, 4), F(1), F(3), F(0), (1, -1)),
    "at a separatrix": on_cubics(F(3, 2), F(5, 4), F(1), F(2), F(0), (-1, -1)),
    # u turns 1e20 times while v turns once
    "almost no weight": with_f_0(F(2), F(1), F(1, 10**40), tangent(F(1, 2)), tangent(F(1, 3))),
}


def two_frequencies(pick):
    """v = u k^2, angles by rational parameters; any sign of G."""

    def positive(low, high):
        return F(pick.randint(int(low * 40), int(high * 40)), 40)

    u, k = positive(0.2, 3), positive(0.25, 2)
    xi, et = (tangent(F(pick.randint(-80, 80), 40)) for _ in range(2))
    return with_f_0(u, u * k * k, positive(0.2, 2), xi, et, pick.choice((1, -1)))


def asymptotic(pick):
    """D- = 0: H - 2a = 3w^2, G = w^3/2."""
    w, a, u, v = (F(pick.randint(8, 100), 40) for _ in range(4))
    if v == w:
        raise ValueError
    return on_cubics(u, v, a, 3 * w * w + 2 * a, w**3 / 2, orbit_members.sides(pick))


def goryachev_chaplygin(pick):
    """f = 0: any, asymptotic, next to those of one frequency, near rest."""
    kind = pick.choice(("any", "asymptotic", "near", "near rest", "rest", "fast"))
    if kind == "any":
        return two_frequencies(pick)
    if kind == "asymptotic":
        return draw_until_real(asymptotic, pick)
    if kind == "near":
        return NEAR[pick.choice(sorted(NEAR))](abs(tiny(pick)))
    up = vertical(pick)
    while not up[2]:
        up = vertical(pick)
    p, q = ratio(pick) / 7, ratio(pick) / 7
    size = {"near rest": tiny(pick), "rest": F(0), "fast": F(40)}[kind]
    w = size * p, size * q, -4 * size * (p * up[0] + q * up[1]) / up[2]
    weight = F(pick.randint(1, 9), pick.randint(1, 9))
    return BODY, (*(weight * x for x in pick.choice(DIRECTIONS)), F(0)), w, up


def hess(pick):
    """A body on Hess's surface, irrational in general, and a start on it; axes in any order."""

    def positive(low, high):
        return F(pick.randint(int(low * 60), int(high * 60)), 60)

    C = positive(0.5, 1)
    B = C + positive(0.1, 0.5)
    A = B + positive(0.05, 0.9) * C
    weight, side = positive(0.5, 2), pick.choice((1, -1))
    torque = [weight * exact.sqrt(C * (A - B)), F(0), side * weight * exact.sqrt(A * (B - C))]
    p, q = F(pick.randint(-60, 60), 60), F(pick.randint(-60, 60), 60)
    omega = [p, q, -A * p * torque[0] / (C * torque[2])]
    up, k = [*vertical(pick)], pick.randint(0, 2)
    return tuple(tuple(row[k:] + row[:k]) for row in ([A, B, C], torque, omega, up))


MOTIONS = orbit_members.MOTIONS | {
    "goryachev-chaplygin": {
        "v constant, et = 0": on_cubics(F(3, 2), F(1), F(1), F(1), F(1, 2)),
        "asymptotic, from below": on_cubics(F(9, 4), F(3, 4), F(2), F(7), F(1, 2)),
        "separatrix": on_cubics(F(3, 2), F(5, 4), F(1), F(2), F(0)),
        "nearly at rest": (
            BODY,
            (F(-945, 932), F(468, 233), F(0)),
            (F(1, 10**9), F(0), F(-1, 3 * 10**8)),
            (F(40, 77), F(-45, 77), F(48, 77)),
        ),
        "1e-8 from D- = 0": on_cubics(F(9, 4), F(5, 4), F(2), F(7) + F(1, 10**8), F(1, 2)),
    }
}

#: In the order in which a scene is tried.
MEMBERS = {
    "euler": euler,
    "lagrange": lagrange,
    "kovalevskaya": kovalevskaya,
    "pendulum": pendulum,
    "staude": staude,
    "goryachev-chaplygin": goryachev_chaplygin,
    "hess": hess,
    **orbit_members.MEMBERS,
}


def start(family, seed):
    """A start of a family, and the generator that made it."""
    pick = Random(f"{family} {seed}")
    return draw_until_real(MEMBERS[family], pick), pick
