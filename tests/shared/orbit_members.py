"""Starts of the families with one orbit: moments, Mg r0, omega, gamma, from the formulas' sheet.

``MOTIONS``: some of each family by name.  ``MEMBERS``: one drawn by a generator of random numbers;
none is where a formula's root would be imaginary, and the draw is repeated.
"""

from fractions import Fraction

from polhode.numbers import exact

F = Fraction
ZERO = F(0)


def sides(pick):
    """Two signs."""
    return pick.choice((1, -1)), pick.choice((1, -1))


def draw_until_real(make, pick):
    """The first draw that is a motion."""
    while True:
        try:
            return make(pick)
        except ValueError:
            continue


def bobylev_steklov(pick):
    """A = 2C, C <= B <= 3C; p = k g3/r from a rational gamma."""
    C, k = F(pick.randint(2, 40), 10), F(pick.randint(1, 60), 10)
    B = C * (1 + F(pick.randint(0, 200), 100))
    a, b = F(pick.randint(1, 30), 10), F(pick.randint(-30, 30), 10)
    over = 1 + a * a + b * b
    gamma = 2 * a / over, 2 * b / over, (1 - a * a - b * b) / over
    r = pick.choice((1, -1)) * F(pick.randint(1, 50), 10)
    return (2 * C, B, C), (C * k, ZERO, ZERO), (k * gamma[2] / r, ZERO, r), gamma


def precession(A, B, C, P, cos, sin, backward=False, signs=(1, 1)):
    """Grioli's, from the definition: an axis at the angle nu to the vertical, spin and turn alike.

    J and I11 are the products of inertia in the frame of the spin.
    """
    x, z = (
        s * exact.sqrt(y)
        for s, y in zip(signs, ((A - B) / (A - C), (B - C) / (A - C)), strict=True)
    )
    e1, e2 = (x, ZERO, z), (-z, ZERO, x)
    I11, J = A + C - B, (C - A) * x * z
    n = exact.sqrt(P / exact.sqrt(I11 * I11 + J * J))
    n = -n if backward else n
    share = n * n / P
    first, second = -share * J * cos, share * (I11 * cos - J * sin * sin)
    omega = [n * (a + cos * b) for a, b in zip(e1, e2, strict=True)]
    gamma = [first * a + second * b for a, b in zip(e1, e2, strict=True)]
    return (
        (A, B, C),
        (P * x, ZERO, P * z),
        (omega[0], n * sin, omega[2]),
        (gamma[0], share * sin * (I11 + J * cos), gamma[2]),
    )


def grioli(pick):
    """Any body A > B > C."""
    A = F(pick.randint(20, 60), 10)
    shares = sorted((F(pick.randint(55, 99), 100), F(pick.randint(45, 99), 100)), reverse=True)
    B, C = A * shares[0], A * shares[1]
    if B == C:
        C -= A / 200
    t = F(pick.randint(-40, 40), 10)
    cos, sin = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    P = F(pick.randint(1, 50), 10)
    return precession(A, B, C, P, cos, sin, pick.random() < 0.5, sides(pick))


def steklov_start(A, B, C, c, share, signs=(1, 1)):
    """p^2 = share of its largest value, p > 0, and the signs of q and r."""
    e = 1 if B > A else -1
    M, N = (A - B) * (A - C) / (A - 2 * C), (A - B) * (A - C) / (A - 2 * B)
    a1 = (B - C) / A
    b2, c2 = A * (A - C) / ((A - 2 * B) * (B - C)), -A * (A - B) / ((A - 2 * C) * (B - C))
    b0, c0 = -e * c / (M * a1), e * c / (N * a1)
    p2 = -b0 / b2 * share
    p, q, r = (exact.sqrt(x) for x in (p2, b0 + b2 * p2, c0 + c2 * p2))
    q, r = signs[0] * q, signs[1] * r
    g1 = e + (M - N) * A * p2 / (2 * (B - C) * c)
    return (A, B, C), (c, ZERO, ZERO), (p, q, r), (g1, M * p * q / c, N * p * r / c)


def steklov(pick):
    """2C < A < 2B, A != B, a body: B + C >= A, A + C >= B."""
    A = F(pick.randint(10, 40), 10)
    while True:
        B, C = A * F(pick.randint(52, 145), 100), A * F(pick.randint(5, 49), 100)
        if A != B and B + C >= A and A + C >= B:
            break
    share = F(pick.randint(0, 100), 100)
    return steklov_start(A, B, C, F(pick.randint(1, 50), 10), share, sides(pick))


def from_hodograph(moments, c, h, p, q, r, slopes):
    """omega and gamma where q^2 = Q(p), r^2 = R(p), with their slopes by p; Mg r0 = (c, 0, 0)."""
    (A, B, C), (dQ, dR) = moments, slopes
    g1 = (h - (A * p * p + B * q * q + C * r * r) / 2) / c
    g2 = q * ((A - B) * p - C * (B - C) * dR / (2 * A)) / c
    g3 = r * ((A - C) * p + B * (B - C) * dQ / (2 * A)) / c
    return moments, (c, ZERO, ZERO), (p, q, r), (g1, g2, g3)


def goryachev_start(x, C, c, p, signs=(1, 1)):
    """The body B = xC; the start at p, of order 1 for C = c = 1."""
    B = x * C
    A, D = 16 * C * (B - C) / (9 * B - 8 * C), 9 * B - 8 * C
    b0 = 4 * B * C * c / ((B - 2 * C) * (3 * B - 2 * C) * (3 * B - 4 * C))
    b2 = -16 * C * C / D**2
    c2 = 16 * (3 * B - 4 * C) * (9 * B * B - 28 * B * C + 16 * C * C) / (B * D**2)
    c4 = -256 * C * C * (3 * B - 4 * C) ** 2 * (5 * B - 4 * C) / (B * b0 * D**4)
    c0 = 2 * b0 * (B - 2 * C) * (3 * B - 2 * C) / (B * C)
    h = b0 * (9 * B * B - 22 * B * C + 12 * C * C) / (4 * C)
    q = signs[0] * exact.sqrt(b0 + b2 * p**2)
    r = signs[1] * exact.sqrt(c0 + c2 * p**2 + c4 * p**4)
    return from_hodograph((A, B, C), c, h, p, q, r, (2 * b2 * p, 2 * c2 * p + 4 * c4 * p**3))


def goryachev(pick):
    """2 < B/C < 8/3."""
    x = 2 + F(pick.randint(1, 66), 100)
    C, c = F(pick.randint(5, 30), 10), F(pick.randint(1, 40), 10)
    signs = sides(pick)
    return goryachev_start(x, C, c, F(pick.randint(-200, 200), 100), signs)


def n_kowalewski_start(x, C, c3, p, signs=(1, 1)):
    """The body B = xC; c from |gamma| = 1 at p = 0."""
    B = x * C
    A, D = 18 * C * (B - C) / (10 * B - 9 * C), 10 * x - 9
    t3, t2 = 4 * x - 3, 2 * x - 3
    b2 = -36 / D**2
    b1 = -3888 * t3 * t2**2 / (x * D**4 * c3)
    c2 = 18 * t2 * (61 * x**2 - 156 * x + 81) / (x * D**2)
    c1 = 486 * t3 * t2**2 * (122 * x**3 - 495 * x**2 + 648 * x - 243) / (x**2 * D**4 * c3)
    b0 = 944784 * t3 * (x - 1) ** 2 * t2**3 / (x**2 * D**6 * c3**2)
    quartic = 488 * x**4 + 30 * x**3 - 4131 * x**2 + 5832 * x - 2187
    c0 = 8748 * (x - 1) * t3 * t2**3 * quartic / (x**3 * D**6 * c3**2)
    cubic = 1310 * x**3 - 4815 * x**2 + 5724 * x - 2187
    h = 1458 * C * t3**2 * t2**3 * cubic / (x**2 * D**6 * c3**2)
    two, three = C * (B - C) * c1 / (2 * A), B * (B - C) * b1 / (2 * A)
    c = exact.sqrt((h - (B * b0 + C * c0) / 2) ** 2 + b0 * two**2 + c0 * three**2)
    q = signs[0] * exact.sqrt(b0 + b1 * p + b2 * p**2)
    r = signs[1] * exact.sqrt(c0 + c1 * p + c2 * p**2 + c3 * p**3)
    slopes = b1 + 2 * b2 * p, c1 + 2 * c2 * p + 3 * c3 * p**2
    return from_hodograph((A, B, C), c, h, p, q, r, slopes)


def n_kowalewski(pick):
    """1.6 < B/C < 2.7."""
    x = F(161 + pick.randint(0, 109), 100)
    C, c3 = F(pick.randint(5, 30), 10), pick.choice((1, -1)) * F(pick.randint(2, 30), 10)
    return n_kowalewski_start(x, C, c3, F(pick.randint(-100, 100), 50) / c3, sides(pick))


def chaplygin_start(j, B1, C, z, signs=(1, 1)):
    """The body B/C = (14 + 6j)/(9 - j^2); the start at p = z^3 with the signs of Y and Z."""
    B = (14 + 6 * j) / (9 - j * j) * C
    A = B * (3 - j) / 3
    ka = -(3 * A - 2 * B) * (A - 2 * B) / ((3 * A - 2 * C) * (A - 2 * C))
    C1 = ka * B1
    c = exact.sqrt(B1 * C1 * (B - C) ** 2 * (C * C * C1 + B * B * B1)) / (3 * A)
    b2 = A * (A - C) / ((A - 2 * B) * (B - C))
    c2 = -A * (A - B) / ((A - 2 * C) * (B - C))
    Y = signs[0] * exact.sqrt(B1 + b2 * z**4)
    Z = signs[1] * exact.sqrt(C1 + c2 * z**4)
    p, q, r = z**3, z * Y, z * Z
    g1 = -(A * p * p + B * q * q + C * r * r) / (2 * c)
    g2 = ((A - B) * p * q - C * (B - C) * (c2 * p * q + C1 * Y / 3) / A) / c
    g3 = ((A - C) * p * r + B * (B - C) * (b2 * p * r + B1 * Z / 3) / A) / c
    return (A, B, C), (c, ZERO, ZERO), (p, q, r), (g1, g2, g3)


def chaplygin(pick):
    """5/2 < B/C < 2.6765: 1 < j < 1.137."""
    j, B1 = 1 + F(pick.randint(1, 130), 1000), F(pick.randint(2, 40), 10)
    C, signs = F(pick.randint(5, 20), 10), sides(pick)
    if 9 * j * j + 14 * j > 27:  # A + C < B
        raise ValueError
    return chaplygin_start(j, B1, C, F(pick.randint(-60, 60), 50), signs)


MOTIONS = {
    "grioli": {
        "backward": precession(F(7, 4), F(5, 4), F(1), F(2), F(3, 5), F(-4, 5), backward=True),
        "other sides": precession(F(2), F(19, 10), F(1, 2), F(3), F(0), F(1), signs=(1, -1)),
        "nearly symmetric": precession(F(2), 2 - F(1, 10**12), F(1), F(1), F(3, 5), F(4, 5)),
    },
    "steklov": {
        "from q = 0": steklov_start(F(1), F(9, 10), F(1, 5), F(13, 10), F(1)),
        "from p = 0": steklov_start(F(5, 2), F(3), F(1), F(2), F(0), (-1, 1)),
        "B nearly A": steklov_start(F(5, 2), F(5, 2) + F(1, 1000), F(1), F(2), F(1, 4)),
    },
    "goryachev": {
        "other signs": goryachev_start(F(5, 2), F(2), F(3), F(-1, 4), (1, -1)),
        "B nearly 8C/3": goryachev_start(F(8, 3) - F(1, 1000), F(1), F(1), F(1, 10)),
    },
    "n-kowalewski": {
        "B = 2C": n_kowalewski_start(F(2), F(1), F(1), F(-1, 5), (-1, 1)),
        "c3 < 0": n_kowalewski_start(F(9, 4), F(3), F(-2), F(1, 4)),
    },
    "chaplygin": {
        "other signs": chaplygin_start(F(12, 11), F(3, 2), F(2), F(-1, 3), (-1, 1)),
        "from rest": chaplygin_start(F(15, 14), F(4, 5), F(1), F(0), (1, -1)),
    },
}

MEMBERS = {
    "bobylev-steklov": bobylev_steklov,
    "grioli": grioli,
    "steklov": steklov,
    "goryachev": goryachev,
    "n-kowalewski": n_kowalewski,
    "chaplygin": chaplygin,
}
