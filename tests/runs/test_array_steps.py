"""Large arrays of starts by one compiled Taylor step: rows as accurate as the tolerance asks."""

import numpy as np
import pytest

import polhode
from polhode.taylor import defaults, lanes
from shared.motions import TURNED, rows_in_quad
from shared.tools import tiers

EPS = 2.0**-52
MANY = 1024  # from so many on the compiled step is taken
UP = [0, 0, 1]
BODIES = {
    "asymmetric": {"moments": [3, 2, 1.5], "centre": [0.25, 0.125, 0.5], "weight": 4},
    "slender": {"moments": [1, 1, 0.01], "centre": [0, 0, 1], "weight": 1},
    "flat": {"moments": [1, 2, 2.99], "centre": [0.5, 0, 0], "weight": 4},
    "sphere": {"moments": [1, 1, 1], "centre": [0, 0, 1], "weight": 1},
    "free": {"moments": [3, 2, 1], "centre": [0, 0, 0], "weight": 0, "gamma": None},
    "turned": {"inertia": TURNED, "centre": [0.25, 0.125, 0.5], "weight": 4},
    "in other units": {"moments": [3, 2, 1.5], "centre": [0.25, 0.125, 0.5], "weight": 4e200},
}


def of(name, tol, **more):
    start = {"omega": [0.5, -0.25, 2], "gamma": UP}
    scene = polhode.top(**start | BODIES[name], end=1, name=name)
    return polhode.propagator(scene, tol=tol, **more)


def starts(go, count, seed=1, spread=1.0):
    """Starts of rates that differ by some powers of ten; the first of them rest, hang, are fast."""
    rng = np.random.default_rng(seed)
    unit = 2.0**go.scene.time_unit
    omega, gamma = (rng.normal(size=(count, 3)) for _ in range(2))
    gamma /= np.sqrt((gamma * gamma).sum(axis=1))[:, None]
    omega *= 10 ** rng.uniform(-2 * spread, spread / 2, count)[:, None]
    omega[:4], gamma[:2] = [[0, 0, 0], [0, 0, 0], [1e3, 0, 1e-3], [1e-200, 0, 0]], [UP, [0, 0, -1]]
    return np.hstack([omega / unit, gamma])[:, : len(go.scene.columns)], unit


def errors(states, exact, rows, unit):
    """Largest error of each row, relative to its fastest rate where that is above 1."""
    scale = np.array([unit] * 3 + [1] * (rows.shape[1] - 3))
    fastest = np.maximum(1, np.abs(rows[:, :3] * unit).max(axis=1))
    return np.abs((states - exact) * scale).max(axis=1) / fastest


def members(count, some):
    """Places of some rows: the special ones but the fast, and others."""
    return np.r_[0, 1, 3, np.linspace(4, count - 1, some).astype(int)]


@pytest.fixture
def counted(monkeypatch):
    """How many motions each call of the compiled step gave up, and the batches that took them."""
    late = []
    at_end = lanes.at_end

    def told(job, steps, which, *others):
        good = at_end(job, steps, which, *others)
        late.append((len(which), int((~good).sum())))
        return good

    monkeypatch.setattr(lanes, "at_end", told)
    return late


@pytest.mark.parametrize(
    ("tol", "name"),
    tiers(
        [(1e-8, "asymmetric"), (1e-4, "free")],
        [(1e-4, "slender"), (1e-11, "flat"), (1e-8, "sphere"), (1e-8, "in other units")],
    ),
)
def test_rows_are_as_accurate_as_the_tolerance_asks(name, tol):
    """No row is off by more than the tolerance for each step; and they are no better than eps."""
    go = of(name, tol)
    rows, unit = starts(go, MANY)
    t = 2.0 * unit * (-1 if tol == 1e-8 else 1)
    found = go(rows, t=t)
    assert go.outcome.done
    which = members(MANY, 3)
    off = errors(found[which], rows_in_quad(go.scene, rows[which], t), rows[which], unit)
    allowed = 4 * tol + 200 * EPS
    assert off.max() < allowed * (100 if name == "slender" else 1)  # whose rate is 100 times w
    assert tol > 1e-10 or np.median(off) < tol
    exact = of(name, None)(rows, t=t)
    everywhere = errors(found, exact, rows, unit)
    assert np.isfinite(everywhere).all()
    assert np.median(everywhere) < tol / 3 + 100 * EPS
    slow = np.abs(rows[:, :3] * unit).max(axis=1) < 10
    assert everywhere[slow].max() < 20 * tol + 1000 * EPS
    assert tol < 1e-10 or everywhere.max() > tol * 1e-5  # steps of such a tolerance are not finer


@pytest.mark.parametrize(("tol", "name"), [(1e-8, "turned"), (1e-4, "free")])
def test_no_bit_depends_on_what_is_beside_a_row(name, tol, monkeypatch):
    go = of(name, tol)
    rows, unit = starts(go, MANY + 5)
    rows[7] = rows[8]
    t = 3 * unit
    found = go(rows, t=t)
    assert np.array_equal(found[7], found[8])
    order = np.random.default_rng(2).permutation(len(rows))
    assert np.array_equal(go(rows[order], t=t), found[order])
    bigger = go(np.concatenate([rows[::-1], *[starts(go, MANY, k)[0] for k in (5, 6)]]), t=t)
    assert np.array_equal(bigger[: len(rows)], found[::-1])
    assert np.array_equal(go(rows, t=[0, t]), np.stack([rows, found], axis=1)) or name == "turned"
    for k in (0, 2, 9):
        alone = go(np.repeat(rows[k : k + 1], MANY, axis=0), t=t)
        assert np.array_equal(alone, np.repeat(found[k : k + 1], MANY, axis=0))
    monkeypatch.setattr(defaults, "ARRAYS", defaults.ARRAYS._replace(starts=1))
    for k in (0, 2, 9):
        assert np.array_equal(go(rows[k : k + 1], t=t)[0], found[k])
    monkeypatch.setattr(lanes, "_SHARED", 0.0)
    for workers in (1, 2, 3):
        assert np.array_equal(go(rows, t=t, workers=workers), found)


def test_a_motion_along_a_separatrix_and_one_beside_it():
    """From the upper rest, by less and less: rates stay small for long and grow at last."""
    go = of("asymmetric", 1e-8)
    gamma = np.array([0.25, 0.125, 0.5]) / np.sqrt(21 / 64)
    for _ in range(2):
        gamma /= np.sqrt(gamma @ gamma)
    rows = np.zeros((MANY, 6))
    rows[:, 3:] = -gamma
    rows[:, 0] = np.ldexp(1.0, -4 - np.arange(MANY) % 48)
    which = np.array([0, 1, 10, 30, 47])
    off = np.abs(go(rows, t=4.0)[which] - rows_in_quad(go.scene, rows[which], 4.0)).max(axis=1)
    assert off.max() < 40 * 1e-8
    assert np.array_equal(go(rows[::-1], t=4.0)[::-1], go(rows, t=4.0))


def test_whose_steps_were_too_long_is_made_again(monkeypatch, counted):
    """With steps far too long the estimate sees it, and the states are those of batches."""
    go = of("asymmetric", 1e-8)
    rows, _ = starts(go, MANY, spread=0.3)
    exact = of("asymmetric", None)(rows, t=2.0)
    monkeypatch.setattr(defaults, "ARRAYS", defaults.ARRAYS._replace(reach=20.0))
    found = go(rows, t=2.0)
    assert counted[0][1] > 0.9 * MANY
    assert len(counted) == 2  # what is left goes in batches
    slow = np.arange(MANY) > 3
    assert np.abs(found - exact)[slow].max() < 2e-7
    monkeypatch.setattr(defaults, "ARRAYS", defaults.ARRAYS._replace(share=1e9))
    assert np.abs(go(rows, t=2.0) - exact)[slow].max() > 1e-3  # what the estimate keeps away


def test_what_the_step_is_not_for_goes_as_before(counted):
    """The type's own tolerance, fewer starts, several times, long ways, more digits."""
    go = of("asymmetric", None)
    rows, _ = starts(go, MANY)
    go(rows, t=1.0)
    assert np.array_equal(of("asymmetric", EPS)(rows, t=1.0), go(rows, t=1.0))
    loose = of("asymmetric", 1e-8)
    slow = np.abs(rows[:, :3]).max(axis=1) < 2
    few, several = loose(rows[: MANY - 1], t=1.0), loose(rows, t=[0.5, 1])
    assert counted == []
    assert np.abs(several[:-1, 1] - few)[slow[:-1]].max() < 1e-7
    loose(rows, t=20.0)
    assert 0 < counted[0][0] < MANY
    assert np.array_equal(loose(rows, t=0.0), rows)
    counted.clear()
    assert np.isfinite(loose(rows, t=-1.0)).all()
    assert counted[0][0] > MANY * 0.9
    assert counted[0][1] < 0.2 * MANY  # else the steps are chosen too long
