"""Tables of programs that drift, in other conventions: numpy alone, nothing of polhode.

    I w' = (I w) x w + Mg gamma x r0,    gamma' = gamma x w,    R' = R [w]x    (R: body -> space)

A program starts exactly and loses digits on the way: by steps that are too long, by noise that
grows, by a moment that is slightly off, by friction.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from shared import tables

VERTICAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Top:
    """A body and a start; ``turn``: the attitude at t = 0, a quaternion, scalar first."""

    inertia: np.ndarray
    centre: np.ndarray
    weight: float
    omega: np.ndarray
    turn: np.ndarray


@dataclass(frozen=True)
class Motion:
    """Rows of a motion: omega and gamma in body axes, quaternions, scalar first."""

    t: np.ndarray
    omega: np.ndarray
    gamma: np.ndarray
    turn: np.ndarray


def product(a, b):
    """Products of quaternions."""
    a, b = np.broadcast_arrays(a, b)
    p, u, q, v = a[..., 0], a[..., 1:], b[..., 0], b[..., 1:]
    vector = p[..., None] * v + q[..., None] * u + np.cross(u, v)
    return np.concatenate([(p * q - np.sum(u * v, axis=-1))[..., None], vector], axis=-1)


def matrix(q):
    """R of quaternions."""
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    columns = [
        product(product(q, np.array([0.0, *axis])), q * [1, -1, -1, -1])[..., 1:]
        for axis in np.eye(3)
    ]
    return np.stack(columns, axis=-1)


def vertical(q):
    """gamma of attitudes."""
    return matrix(q)[..., 2, :]


def cross(a, b):
    """The vector product, of lists of three (numpy's takes ten times as long for so few)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def acceleration(top, omega, turn):
    omega = omega.tolist()
    a, b, c, d = turn.tolist()
    square = a * a + b * b + c * c + d * d
    up = [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]
    weight = top.weight / square
    spin = cross((top.inertia @ omega).tolist(), omega)
    torque = [x + weight * y for x, y in zip(spin, cross(up, top.centre.tolist()), strict=True)]
    return np.linalg.solve(top.inertia, torque)


def turning(turn, omega):
    a, b, c, d = turn.tolist()
    p, q, r = omega.tolist()
    return 0.5 * np.array(
        [
            -b * p - c * q - d * r,
            a * p + c * r - d * q,
            a * q + d * p - b * r,
            a * r + b * q - c * p,
        ]
    )


def rate(top, state):
    omega, turn = state[:3], state[3:]
    return np.concatenate([acceleration(top, omega, turn), turning(turn, omega)])


def semi_implicit(top, y, h):
    omega = y[:3] + h * acceleration(top, y[:3], y[3:])
    turn = y[3:] + h * turning(y[3:], omega)
    return np.concatenate([omega, turn / np.linalg.norm(turn)])


def of_tops(method):
    """A method of ``shared.tables`` as one step of a top."""
    return lambda top, y, h: method(lambda _, y: rate(top, y), y, h)


rk4 = of_tops(tables.rk4)


def run(top, times, step, longest):
    """The motion by a method whose steps are no longer than that."""
    y, now, rows = np.concatenate([top.omega, top.turn]), 0.0, []
    for t in times:
        count = max(1, math.ceil((t - now) / longest - 1e-9)) if t > now else 0
        for _ in range(count):
            y = step(top, y, (t - now) / count)
        now = t
        rows.append(y)
    states = np.array(rows)
    turn = states[:, 3:] / np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
    return Motion(np.array(times), states[:, :3], vertical(turn), turn)


def random_unit(random, count=4):
    q = random.normal(size=count)
    return q / np.linalg.norm(q)


def rounded(values, places=4):
    return np.round(np.asarray(values, dtype=float), places)


def random_top(random, kind):
    """A body of numbers of few decimals: of a full tensor, in its principal axes, symmetric."""
    while True:
        moments = random.uniform(0.5, 2.0, 3)
        if kind == "symmetric":
            moments[1] = moments[0]
        moments = rounded(moments)
        if max(moments) < 0.95 * (sum(moments) - max(moments)):
            break
    inertia = np.diag(moments)
    if kind == "full":
        r = matrix(random_unit(random))
        inertia = rounded(r @ inertia @ r.T)
    centre = VERTICAL * 0.4 if kind == "symmetric" else rounded(random.uniform(-0.5, 0.5, 3))
    weight = 0.0 if random.random() < 0.2 else 1.5
    omega = rounded(random.normal(size=3) * random.choice([0.5, 1.0, 3.0]), 3)
    if random.random() < 0.15 and weight:
        omega = np.zeros(3)
    return Top(inertia, centre, weight, omega, random_unit(random))


def drifting(random, top, times, exact, kind):
    """The motion by a program that drifts."""
    fastest = float(np.linalg.norm(exact.omega, axis=1).max())
    speed = max(1.0, fastest)
    if kind in STEPS:
        method, longest = STEPS[kind]
        return run(top, times, method, longest / speed)
    if kind == "noise":
        share = exact.t[:, None] / exact.t[-1]
        size = 10 ** random.uniform(-2.5, -1)
        noise = [share * size * random.normal(size=(len(times), n)) for n in (3, 3, 4)]
        turn = exact.turn + noise[2]
        turn = turn / np.linalg.norm(turn, axis=1, keepdims=True)
        return Motion(exact.t, exact.omega + fastest * noise[0], exact.gamma + noise[1], turn)
    by = 1 + 10 ** random.uniform(-3, -2)
    axis = random.integers(3)
    factors = np.ones((3, 3))
    factors[axis, axis] = by
    return run(replace(top, inertia=top.inertia * factors), times, rk4, 0.03 / speed)


STEPS = {
    "euler": (of_tops(tables.euler), 0.004),
    "semi-implicit": (semi_implicit, 0.03),
    "midpoint": (of_tops(tables.midpoint), 0.08),
    "rk4": (rk4, 0.4),
}
DRIFTS = (*STEPS, "noise", "moment")


def random_times(random):
    """Output times, evenly spread; the first row the start or not; few rows or many."""
    count = int(random.choice([4, 6, 12, 40, 150]))
    step = 10 ** random.uniform(-1.5, -0.2)
    first = 0 if random.random() < 0.7 else 1
    return [round(step, 4) * k for k in range(first, first + count)]


# -- conventions: what a file holds, and the words that name it -------------------------------


def columns(motion):
    return {
        "t": motion.t,
        **dict(zip("pqr", motion.omega.T, strict=True)),
        **{f"gamma{k + 1}": motion.gamma[:, k] for k in range(3)},
        **{f"q{k}": motion.turn[:, k] for k in range(4)},
    }


def degrees(motion, _=None):
    return replace(motion, omega=np.degrees(motion.omega))


def scalar_last(motion, _=None):
    return replace(motion, turn=np.roll(motion.turn, -1, axis=1))


def inverse(motion, _=None):
    return replace(motion, turn=motion.turn * [1, -1, -1, -1])


def left_handed(motion, _=None):
    """z reflected, of the body and of space; omega is a pseudovector."""
    return replace(
        motion,
        omega=motion.omega * [-1, -1, 1],
        gamma=motion.gamma * [1, 1, -1],
        turn=motion.turn * [1, -1, -1, 1],
    )


def in_space(*turn):
    """The attitude from other axes of space; of chance, if no quaternion is given."""
    return lambda motion, random=None: replace(
        motion, turn=product(np.array(turn) if turn else random_unit(random), motion.turn)
    )


def turned_in_body(motion, random):
    return replace(motion, turn=product(motion.turn, random_unit(random)))


def downward(motion, _=None):
    return replace(motion, gamma=-motion.gamma)


def along_space(motion, _=None):
    return replace(motion, omega=np.einsum("nij,nj->ni", matrix(motion.turn), motion.omega))


def exchanged(motion, _=None):
    return replace(motion, omega=motion.omega[:, [1, 0, 2]])


def other_body_axes(motion, _=None):
    signs = np.array([1, -1, -1])
    turn = product(motion.turn, np.array([0.0, 1, 0, 0]))
    return replace(motion, omega=motion.omega * signs, gamma=motion.gamma * signs, turn=turn)


Y_UP = in_space(math.sqrt(0.5), -math.sqrt(0.5), 0, 0)

#: Conventions, and the part and the words by which each is named.
CONVENTIONS = {
    "degrees": (degrees, {"omega": "degrees"}),
    "rpm": (lambda m, _: replace(m, omega=m.omega * 30 / np.pi), {"omega": "rpm"}),
    "scalar last": (scalar_last, {"attitude": "scalar-last"}),
    "degrees, scalar last": (
        lambda m, _: scalar_last(degrees(m)),
        {"omega": "degrees", "attitude": "scalar-last"},
    ),
    "inverse": (inverse, {"attitude": "body from space"}),
    "left-handed": (
        left_handed,
        {"omega": "p q r = -p -q r", "gamma": "gamma1 gamma2 gamma3 = gamma1 gamma2 -gamma3"},
    ),
    "y up": (Y_UP, {"attitude": "y up"}),
    "turned in space": (in_space(), {"attitude": "a constant rotation of"}),
    "turned in the body": (turned_in_body, {"attitude": "a constant rotation of"}),
    "downward": (downward, {"gamma": "the downward vertical"}),
    "along space": (along_space, {"omega": "along the axes of space"}),
    "exchanged": (exchanged, {"omega": "p q r = q p r"}),
    "body axes": (
        other_body_axes,
        {"omega": "p q r = p -q -r", "attitude": "body x y z = x -y -z"},
    ),
}


def other_products(top, random):
    """The body with products of inertia of the other sign: all, or one; None where none is."""
    signs = np.ones((3, 3))
    i, j = [(0, 1), (0, 2), (1, 2)][random.integers(3)]
    if random.random() < 0.5:
        signs = 2 * np.eye(3) - 1
    else:
        signs[i, j] = signs[j, i] = -1
    inertia = top.inertia * signs
    moments = np.linalg.eigvalsh(inertia)
    return replace(top, inertia=inertia) if moments[0] > 0.01 + moments[2] - moments[1] else None


# -- tables that are wrong, and in no other convention ----------------------------------------


def plain_top(random):
    """A body of round numbers that spins about one of its axes, or two."""
    moments = rounded(random.permutation([1.0, 1.5, 2.0]))
    omega = np.zeros(3)
    omega[random.choice(3, size=random.integers(1, 3), replace=False)] = random.choice([1.0, 3.0])
    turn = product(np.array([math.cos(0.3), math.sin(0.3), 0, 0]), np.array([1.0, 0, 0, 0]))
    return Top(np.diag(moments), VERTICAL / 2, random.choice([0.0, 1.0]), omega, turn)


def another(random, top, times):
    """The motion of another top."""
    kinds = ["full", "principal", "symmetric"]
    return run(random_top(random, random.choice(kinds)), times, rk4, 0.02)


def another_plain_one(random, top, times):
    """A body that spins about other axes, and not as fast: else its first rows are the scene's."""
    second_top = plain_top(random)
    return run(replace(second_top, omega=0.7 * second_top.omega), times, rk4, 0.02)


def another_body(random, top, times):
    """The same start of another body."""
    second_top = random_top(random, "full")
    return run(replace(top, inertia=second_top.inertia, centre=second_top.centre), times, rk4, 0.01)


def another_weight(random, top, times):
    return run(replace(top, weight=3 * top.weight + 1.0), times, rk4, 0.01)


def another_start(random, top, times):
    omega = top.omega + random.normal(size=3) * 10 ** random.uniform(-2, 0.5)
    return run(replace(top, omega=omega), times, rk4, 0.01)


def another_attitude(random, top, times):
    """A heavy top from elsewhere, which is no rotation of the scene's motion."""
    heavy = replace(top, weight=max(top.weight, 1.0), omega=top.omega + random.normal(size=3))
    return run(replace(heavy, turn=random_unit(random)), times, rk4, 0.01)


def noise(random, top, times):
    size = random.choice([0.1, 1.0, 3.0])
    turn = random.normal(size=(len(times), 4))
    turn = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    instants = np.array(times)
    return Motion(instants, size * random.normal(size=(len(times), 3)), vertical(turn), turn)


def wandering(random, top, times):
    """The start, and steps of chance from there."""
    steps = 0.1 * random.normal(size=(len(times), 7)).cumsum(axis=0)
    turn = top.turn + steps[:, :4]
    turn = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    return Motion(np.array(times), top.omega + steps[:, 4:], vertical(turn), turn)


def stuck(random, top, times):
    """The start again and again."""
    turn = np.repeat([top.turn], len(times), axis=0)
    return Motion(np.array(times), np.repeat([top.omega], len(times), axis=0), vertical(turn), turn)


def right(random, top, times):
    """A program that drifts, in the scene's conventions."""
    exact = run(top, times, rk4, 0.02)
    return drifting(random, top, times, exact, random.choice(DRIFTS))


WRONG = {
    program.__name__.replace("_", " "): program
    for program in (
        *(another, another_plain_one, another_body, another_weight, another_start),
        another_attitude,
        *(noise, wandering, stuck, right),
    )
}


# -- files of a convention ----------------------------------------------------------------------

PRODUCTS = "products of inertia"
SCENE_QUATERNION = "quaternion of the scene"
NAMES = (*CONVENTIONS, PRODUCTS, SCENE_QUATERNION)


@dataclass(frozen=True)
class File:
    """A table with the scene that it is held against.

    ``top``: the scene's, ``turn`` the quaternion that its author typed.  ``words``: what names its
    convention, by part.  ``exact``: the first rows of a program that does not drift.
    """

    top: Top
    turn: np.ndarray
    columns: dict[str, np.ndarray]
    words: dict[str, str]
    exact: dict[str, np.ndarray]


def of_convention(seed, name):
    """A random file in a convention; of some only the attitude is there."""
    random = np.random.default_rng([seed, 7])
    kind = random.choice(["full", "principal", "symmetric"])
    own, top = None, None
    while own is None:
        top = random_top(random, "full" if name == PRODUCTS else kind)
        own = other_products(top, random) if name == PRODUCTS else top
    return file_of(name, top, own, random_times(random), random.choice(DRIFTS), random)


def plain_file(name):
    """A file in a convention: a program with rough steps, of a body that has a closed form."""
    random = np.random.default_rng(5)
    top = random_top(random, "full" if name == PRODUCTS else "symmetric")
    top = replace(top, weight=1.5, omega=np.array([0.4, -0.7, 1.9]))
    own = top
    if name == PRODUCTS:
        own = replace(top, inertia=top.inertia * (2 * np.eye(3) - 1))
    return file_of(name, top, own, [0.25 * k for k in range(17)], "semi-implicit", random)


def file_of(name, top, own, times, drift, random):
    """A program of ``own`` that drifts, held against ``top``."""
    exact = run(own, times, rk4, 0.05 / max(1.0, float(np.linalg.norm(own.omega))))
    motion = drifting(random, own, times, exact, drift)
    turn = top.turn
    if name == PRODUCTS:
        words = {"omega": "products of inertia of the other sign"}
    elif name == SCENE_QUATERNION:
        turn = np.roll(top.turn, -1)
        words = {"attitude": "the scene's quaternion taken as scalar-last"}
        if not top.weight:  # the same motion, turned
            words = {"gamma": words["attitude"]}
    else:
        change, words = CONVENTIONS[name]
        rotation = int(random.integers(1000))
        motion, exact = (change(m, np.random.default_rng(rotation)) for m in (motion, exact))
    both = [columns(motion), {name: x[:EXACT_ROWS] for name, x in columns(exact).items()}]
    if [*words] == ["attitude"] and random.random() < 0.3:
        both = [{n: x for n, x in table.items() if n in ("t", *QUATERNION)} for table in both]
    return File(top, turn, both[0], words, both[1])


def wrong_file(seed, name):
    """A random table that is in no other convention; of some a part alone is there."""
    random = np.random.default_rng([seed, 8])
    if name == "another plain one" or random.random() < 0.2:
        top = plain_top(random)
    else:
        top = random_top(random, random.choice(["full", "principal", "symmetric"]))
    table = columns(WRONG[name](random, top, random_times(random)))
    some = [[*table], ["t", *QUATERNION], ["t", *"pqr"]][random.integers(3)]
    table = {n: table[n] for n in some}
    return File(top, top.turn, table, {}, table)


EXACT_ROWS = 12
QUATERNION = ("q0", "q1", "q2", "q3")
