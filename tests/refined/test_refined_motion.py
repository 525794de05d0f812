"""Refined runs against closed forms, against themselves in other intervals, at their limits."""

import random
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

import polhode
from polhode import Body, Scene
from polhode.numbers.number_types import Doubles
from polhode.refined import double_run, refinement
from polhode.refined.collocation_tables import LARGEST_FIELD, Tables, tables
from polhode.refined.compiled_field import (
    COEFFICIENTS,
    FIELD_SHIFT,
    VARIABLES,
    CannotRefine,
    Kernels,
    Limbs,
    TooFarOff,
    kernels,
)
from polhode.refined.refinement import (
    QUAD,
    Accuracy,
    ChainStretch,
    OutputSide,
    accuracy,
    errors_made,
    estimate,
    refine,
)
from shared.motions import ASYMMETRIC, asymmetric
from shared.tools import tiers


def run(scene, *times, target=QUAD, **options):
    """A refinement at times in the scene's units."""
    unit = Fraction(2) ** scene.time_unit
    return refine(scene, [Fraction(t) / unit for t in times], target, **options)


def distance(first, second, i=-1):
    """Largest differences of w and of gamma."""
    pairs = list(zip(first.exactly(i), second.exactly(i), strict=True))
    return [max(abs(float(a - b)) for a, b in pairs[k : k + 3]) for k in (0, 3)]


def within(errors, motion, i=-1):
    return bool((np.array(errors) <= motion.estimate.errors[i]).all())


def random_tops():
    draw = random.Random(5)
    for k in range(6):
        a, b = (Fraction(draw.randint(20, 100), 50) for _ in range(2))
        c = a + b - Fraction(draw.randint(1, 80), 50) * min(a, b)
        moments = [a, b, c] if k % 4 else [a, a, a / 10000]  # slender, too
        centre = [Fraction(draw.randint(-50, 50), 100) for _ in range(3)]
        body = Body.of_moments(moments, centre, 0 if k == 5 else 1)
        omega = tuple(Fraction(draw.randint(-200, 200), 100) for _ in range(3))
        yield Scene(body, omega, ("0.48", "0.6", "0.64")), 10 if k % 2 else -10


RELEASED = Scene(ASYMMETRIC, (0, 0, 0), (1, 0, 0))
VIOLENT = replace(asymmetric(), body=replace(ASYMMETRIC, weight=50))


@pytest.mark.parametrize(("scene", "end"), [*random_tops(), (RELEASED, 10), (VIOLENT, 10)])
def test_another_grouping_of_steps_agrees_within_the_estimate(scene, end):
    six, five = run(scene, end), run(scene, end, m=5)
    assert within(distance(six, five), six)
    assert six.states != five.states
    assert scene is VIOLENT or six.intervals <= five.intervals
    if scene is RELEASED:
        assert max(six.estimate.errors[0]) < 1e-31
    if scene is VIOLENT:  # cuts its intervals
        assert six.intervals > six.steps / 6


@dataclass(frozen=True)
class FewNodes(Accuracy):
    """So many nodes, however few they are."""

    count: int = 12

    def nodes(self, m):
        return self.count

    @property
    def tail(self):
        return 1.0


def test_the_ends_are_good_to_the_square_of_the_stages():
    """Two more nodes take away what two more Legendre coefficients are, squared: 5² to the 4th
    power at best; measured 60 to 80 a node."""
    scene, end = asymmetric(), 100
    true = run(scene, end, target=accuracy(40))
    errors = [
        max(distance(run(scene, end, target=FewNodes(1e-34, QUAD.limbs, 8, n), m=4), true))
        for n in (15, 17, 19, 21)
    ]
    assert 1e-23 < errors[0] < 1e-20
    for before, after in pairwise(errors):
        assert 1e3 < before / after < 2e4


def test_what_few_nodes_neglect_is_within_the_estimate_and_not_far_below():
    """Ends within one interval or two, where no motion multiplies errors and none cancel: of all
    motions the worst one is some 4 times better than its estimate."""
    worst = []
    for scene in (
        asymmetric(),
        polhode.load("kovalevskaya/generic"),
        polhode.load("lagrange/spherical-pendulum"),
        polhode.load("euler/dzhanibekov"),
    ):
        ends = [Fraction(k, 4) for k in range(1, 9)]
        true = run(scene, *ends, target=accuracy(40))
        for count in (9, 11, 13):
            motion = run(scene, *ends, target=FewNodes(1e-34, QUAD.limbs, 8, count))
            for i in range(len(ends)):
                off = distance(motion, true, i)
                assert within(off, motion, i)
                worst.append(max(motion.estimate.errors[i]) / max(off))
    assert 2 < min(worst) < 20


def astray(size):
    """The states of a run in double, off by so much."""
    before, draw = double_run.Base.states, np.random.default_rng(3)
    return lambda self, t: before(self, t) + draw.uniform(-size, size, (6, *t.shape))


def test_guesses_that_are_off_change_less_than_the_estimate_or_are_refused(monkeypatch):
    scene = asymmetric()
    honest = run(scene, 30)
    monkeypatch.setattr(double_run.Base, "states", astray(1e-12))
    bent = run(scene, 30)
    assert bent.states != honest.states
    assert within(distance(honest, bent), honest)
    assert within(distance(honest, bent), bent)
    monkeypatch.undo()
    monkeypatch.setattr(double_run.Base, "states", astray(1e-5))
    with pytest.raises(CannotRefine, match="drifts within one interval"):
        run(scene, 30)


@pytest.mark.parametrize("digits", tiers([34], [50]))
def test_products_by_levels_and_the_compiled_field_are_those_of_integers(digits):
    """Of four limbs, and of more, which are no other code."""
    target = accuracy(digits)
    for steps in (5, 6):
        table = tables(target.limbs, target.nodes(steps))
        assert products_are_exact(table, target.limbs)
    spoilt = replace(table, levels=tuple(level * (1 + 2.0**-52) for level in table.levels))
    assert not products_are_exact(spoilt, target.limbs)
    assert field_error(kernels(target.limbs), target.limbs) <= 2.0**-target.limbs.bits


def test_a_block_of_one_interval_is_one(monkeypatch):
    """As many as are still near the run in double: one is enough, none is not."""
    scene = polhode.load("euler/flat")
    solve, good = refinement.solve, [1]
    whole = run(scene, 9)

    def astray(*arguments):
        if good:
            raise TooFarOff(good.pop())
        return solve(*arguments)

    monkeypatch.setattr(refinement, "solve", astray)
    motion = run(scene, 9)
    assert not good
    assert motion.estimate.errors[-1].max() < 1e-32
    assert max(distance(motion, whole)) < 1e-32
    good.append(0)
    with pytest.raises(CannotRefine, match="within one interval"):
        run(scene, 9)


# -- The error estimate of a refined chain, beside each output's own -------------------------------

OUTPUTS, INTERVALS, ROUNDING = 90, 60, 1e-3


def chain():
    """Stretches and sides in which no two outputs have the same error or kappa."""
    draw = np.random.default_rng(11)

    def turn(*shape):
        return np.eye(6) + 0.1 * draw.normal(size=(*shape, 6, 6))

    stretches = [
        ChainStretch(turn(count), draw.uniform(0.1, 1.0, count), scale)
        for count, scale in ((INTERVALS // 3, 2.0), (INTERVALS - INTERVALS // 3, 0.5))
    ]
    edges = np.sort(draw.integers(0, INTERVALS + 1, OUTPUTS))
    edges[:2] = 0  # before the end of the first interval
    sides = [OutputSide(int(edge), turn(), float(draw.uniform(0.1, 5.0)), 0.5) for edge in edges]
    return stretches, sides


def test_an_output_between_those_with_an_estimate_takes_the_larger_of_its_neighbours():
    stretches, sides = chain()
    estimates = estimate(stretches, sides, ROUNDING)
    alone = [estimate(stretches, [side], ROUNDING) for side in sides]
    own = np.array([stretch.errors[0] for stretch in alone])
    kappas = np.array([stretch.kappa[0] for stretch in alone])
    chosen = [k for k in range(OUTPUTS) if np.allclose(estimates.errors[k], own[k], rtol=1e-12)]
    assert len(chosen) == 32
    assert (chosen[0], chosen[-1]) == (0, OUTPUTS - 1)
    for k in range(OUTPUTS):
        both = [max(c for c in chosen if c <= k), min(c for c in chosen if c >= k)]
        assert estimates.errors[k] == pytest.approx(own[both].max(axis=0), rel=1e-12)
        assert estimates.kappa[k] == pytest.approx(kappas[both].max(), rel=1e-12)


def test_what_each_interval_adds_is_carried_to_the_output_by_the_transitions_after_it():
    """By products of all of them, one by one; rounding adds up by its square."""
    stretches, sides = chain()
    parts = [(stretch, k) for stretch in stretches for k in range(len(stretch.errors))]
    for side in sides[::5]:
        own = reached(np.eye(6), side.scale)
        carried, sums, squares = side.transition, own * side.error, own**2
        for stretch, k in reversed(parts[: side.edge]):
            reach = reached(carried, stretch.scale)
            sums, squares = sums + reach * stretch.errors[k], squares + reach**2
            carried = carried @ stretch.transitions[k]
        estimates = estimate(stretches, [side], ROUNDING)
        assert estimates.errors[0] == pytest.approx(sums + ROUNDING * np.sqrt(squares), rel=1e-12)
        assert estimates.kappa[0] == pytest.approx(np.abs(carried).sum(axis=1).max(), rel=1e-12)


def reached(carried, scale):
    """Largest errors of w and gamma by errors of w up to scale and of gamma up to 1."""
    whole = np.abs(carried) @ np.array([scale] * 3 + [1.0] * 3)
    return np.array([whole[:3].max(), whole[3:].max()])


def test_collocation_neglects_what_grows_as_the_square_of_the_last_coefficients():
    left, tails = np.array([1e-30, 2e-30]), np.array([1e-10, 3e-12])
    assert errors_made(left, 0 * tails).tolist() == left.tolist()
    single, two = errors_made(0 * left, tails), errors_made(0 * left, 2 * tails)
    assert (single > 0).all()
    assert two == pytest.approx(4 * single, rel=1e-15)
    assert (errors_made(left, tails) == left + single).all()


# -- The compiled field and the products by levels beside integers, to the bit ---------------------
# Only these two, and the arithmetic of limbs, decide which digits of a refined run come out; a
# fault in what corrects the stages would show as sweeps that do not converge.  A compiler that
# contracts or reassociates, a damaged cache, a BLAS of fewer digits: all would show here.

NODES = 8  # that the field is tried at
LONGEST = 16  # H
_COLUMNS = 2


def field_error(compiled: Kernels, limbs: Limbs) -> float:
    """The largest error of H f, over max(1, H), at random states; all in integers beside it."""
    draw = random.Random(1)
    unit = 1 << limbs.finest
    k = [[draw.randint(-unit, unit) for _ in range(NODES)] for _ in range(COEFFICIENTS)]
    x = [[draw.randint(-unit, unit) for _ in range(NODES)] for _ in range(VARIABLES)]
    lengths, exact = [], []
    for n in range(NODES):
        rates = field([row[n] for row in x], [row[n] for row in k], unit)
        largest = max(1, *map(abs, rates))
        most = int(LARGEST_FIELD) * unit**4 // largest
        length = min(draw.randint(0, LONGEST * unit), most)
        lengths.append(length)
        exact.append([rate * length for rate in rates])
    columns = _columns(limbs, x)
    parameters = _columns(limbs, [*k, lengths])
    outputs = np.empty((VARIABLES * limbs.count, NODES))
    compiled.field(columns, pars=parameters, outputs=outputs)
    if not np.isfinite(outputs).all():
        return float("inf")
    worst = Fraction(0)
    for n in range(NODES):
        for v in range(VARIABLES):
            value = limbs.value(outputs[v * limbs.count : (v + 1) * limbs.count, n])
            error = abs(value - Fraction(exact[n][v], unit**4))
            worst = max(worst, error / max(Fraction(1), Fraction(lengths[n], unit)))
    return float(worst)


def field(x: list[int], k: list[int], unit: int) -> list[int]:
    """The rates (3.29) in integers: x and k in units of 1/one, the rates in units of 1/one³."""
    w, g = x[:3], x[3:]
    values = []
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        weight = k[3 + 2 * a] * g[b] + k[4 + 2 * a] * g[c]
        values.append(k[a] * w[b] * w[c] + unit * weight)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        values.append(unit * (g[b] * w[c] - g[c] * w[b]))
    return values


def _columns(limbs: Limbs, rows: list[list[int]]) -> Doubles:
    """Integers in units of 2**-finest as limbs, the limbs of a row one below the other."""
    split = np.array([[limbs.split_integer(x) for x in row] for row in rows])
    return np.ascontiguousarray(split.transpose(0, 2, 1).reshape(-1, len(rows[0])))


def products_are_exact(table: Tables, limbs: Limbs) -> bool:
    """Whether the levels of A·F equal integer arithmetic, bit for bit, for fields up to 4."""
    kind = limbs.shifted(FIELD_SHIFT)
    most = int(LARGEST_FIELD) << kind.finest
    draw = random.Random(1)
    shape = (VARIABLES, len(table.nodes), _COLUMNS, limbs.count)
    numbers = [kind.split_integer(draw.randint(-most, most)) for _ in range(np.prod(shape[:3]))]
    fields = np.ascontiguousarray(np.array(numbers).reshape(shape).transpose(0, 3, 1, 2))
    levels = table.integrated(fields)[:-1]
    row = int(np.abs(table.levels[-1]).sum(axis=1).argmax())
    return all(
        level[0, row, 0] * 2.0 ** limbs.place(i + 2)
        == exact_product(rows[row], fields[0, :, :, 0], limbs)
        for i, (level, rows) in enumerate(zip(levels, table.levels, strict=True))
    )


def exact_product(row: Doubles, field: Doubles, limbs: Limbs) -> int:
    """A row of ``Tables.levels`` times the limbs (L, M) of a field, in units of its level."""
    nodes = field.shape[1]
    top = len(row) // nodes  # limbs A_top ... A_1 against F_1 ... F_top
    table, kind = limbs.shifted(-FIELD_SHIFT), limbs.shifted(FIELD_SHIFT)
    total = 0
    for j in range(1, top + 1):
        part = row[(j - 1) * nodes : j * nodes] * 2.0 ** table.place(top + 1 - j)
        factor = field[j - 1] * 2.0 ** kind.place(j)
        total += sum(int(a) * int(f) for a, f in zip(part.tolist(), factor.tolist(), strict=True))
    return total
