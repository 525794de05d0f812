"""The checker's bounds of jets beside what they bound: a step, the norm, a start, a period's ball.

Each holds as it stands, and not without one of its terms; ``test_stability_certificate`` has what
an ordinary orbit notices.
"""

import random
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb, arb_mat

from polhode.certificates import verify
from polhode.numbers.flint_context import ctx
from shared.proofs import body_of

RHO = 3  # bits


@pytest.fixture(autouse=True)
def precision():
    with ctx.workprec(64):
        yield


def norm_of(moments, torque, state, weight_bits):
    """The norm that the checker chooses near a state."""
    inertia = [[arb(x if i == j else 0) for j in range(3)] for i, x in enumerate(moments)]
    centres = [[arb(x) for x in state]]
    run = SimpleNamespace(inertia=inertia, torque=[arb(x) for x in torque], centres=centres)
    return verify.Norm(run, weight_bits)


def jets_of(*columns):
    """Six jets by their coefficients: numbers of each monomial."""
    return [verify.Jet([arb(x) for x in row]) for row in zip(*columns, strict=True)]


def still(state, *more):
    """Jets of a state, with some further coefficients."""
    zeros = [[0.0] * 6] * (len(verify.MONOMIALS) - 1 - len(more))
    return jets_of(state, *more, *zeros)


def size_of(norm, jets):
    """|z| of jets that are known, not a bound."""
    q = np.array([[float(x) for x in row] for row in norm.q.table()])
    columns = np.array([[float(x.mid()) for x in row.parts] for row in jets])
    weights = [float(x) for x in norm.weights]
    return float(np.linalg.norm(q @ columns, axis=0) @ weights)


def moved(body, jets, h, bits=300):
    """Where jets go, by one long series."""
    with ctx.workprec(bits):
        algebra = verify.Algebra(verify.FACTORS, [0] * len(verify.MONOMIALS))
        series = verify.taylor_over(algebra, body, [row.parts for row in jets], arb(h), bits)
        return [
            verify.Jet(x + sum(more, arb(0)) for x, more in zip(row.parts, rows, strict=True))
            for row, rows in zip(jets, series, strict=True)
        ]


def step(body, jets, eps, h, norm, bits=128):
    """Where a step takes the jets within eps of these, and how far it may be off."""
    with ctx.workprec(64):
        end, off = verify.jet_step(body, jets, arb(eps), (arb(h), arb(1)), norm, bits)
    return end, float(off)


def difference(some, others):
    with ctx.workprec(300):
        return [x - y for x, y in zip(some, others, strict=True)]


# -- one step -------------------------------------------------------------------------------------

THIN, MIDDLE = (1, 0.99, 0.01), (0, 1, 0, 0, 0, 0)


def farthest(body, norm, state, h, eps):
    """|z(1)| of a z(0) with |z(0)| = eps that is stretched most, of those without xi."""
    q = arb_mat(norm.q)
    flow = (arb_mat(verify.slope(body, [arb(x) for x in state])) * arb(h)).exp()
    in_frame = np.array([[float(x) for x in row] for row in (q * flow * norm.inverse).table()])
    direction = np.linalg.svd(in_frame)[2][0]
    z = (norm.inverse * arb_mat([[arb(x * eps)] for x in direction])).entries()
    begin = still([arb(x) + y.mid() for x, y in zip(state, z, strict=True)])
    return size_of(norm, difference(moved(body, begin, h), moved(body, still(state), h)))


def by_the_symmetric_part(_):
    """Steady rotation about the middle axis of a thin body, whose neighbours leave it."""
    body, norm = body_of(THIN), norm_of(THIN, (0, 0, 0), MIDDLE, RHO)
    truth = farthest(body, norm, MIDDLE, 2**-4, 1e-9)
    assert truth > 1.3e-9
    return truth, step(body, still(MIDDLE), 1e-9, 2**-4, norm)[1]


@pytest.mark.parametrize("power", [-1200, -60, 60, 1200])
def test_the_norm_is_that_of_motions_whatever_the_unit_of_mass(power):
    """A body of another mass moves the same way, so a step is as sharp."""
    norms = []
    for mass in (arb(1), arb(2) ** power):
        inertia = [
            [arb(x) * mass if i == j else arb(0) for j in range(3)] for i, x in enumerate(TOP[0])
        ]
        torque, centres = [arb(x) * mass for x in TOP[1]], [[arb(1)] * 6]
        run = SimpleNamespace(inertia=inertia, torque=torque, centres=centres)
        norms.append(verify.Norm(run, RHO))
    assert norms[0].q == norms[1].q
    assert [float(x) for x in norms[0].into[:3]] != [1.0] * 3


def by_what_depends_on_xi(_):
    """A ball at rest but for w_1 = s xi_1: A_0 is 0, and gamma turns."""
    spin, rest = [1.0, 0, 0, 0, 0, 0], [0.0] * 6
    body, norm = body_of((1, 1, 1)), norm_of((1, 1, 1), (0, 0, 0), spin, 0)
    begin = still(rest, spin)
    off = still([0, 0, 0, 0, 1e-9, 0])
    near = [x + y for x, y in zip(begin, off, strict=True)]
    truth = size_of(norm, difference(moved(body, near, 0.5), moved(body, begin, 0.5)))
    assert truth > 1.6e-9  # exp(1/2) but for a term of the fourth degree
    return truth, step(body, begin, 1e-9, 0.5, norm)[1]


def by_a_guess_that_does_not_move(monkeypatch):
    state, moments, torque = [0.3, 0.2, 1.0, 0.6, 0.0, 0.8], (2, 1.5, 1), (0.3, 0.2, 0.5)
    body, norm = body_of(moments, torque), norm_of(moments, torque, state, RHO)
    begin = still(state, [1.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1.0, 0])
    truth = size_of(norm, difference(moved(body, begin, 2**-7), begin))
    parts = len(verify.MONOMIALS)
    monkeypatch.setattr(verify, "taylor_over", lambda *_: [[[] for _ in range(parts)]] * 6)
    return truth, step(body, begin, 0, 2**-7, norm)[1]


def by_what_is_quadratic_in_a_wide_start(monkeypatch):
    """Euler's top at rest, A = 0, in a norm that it does not keep."""
    monkeypatch.setattr(verify, "_frame_of", lambda run: verify._unit())
    body, norm = body_of((3, 2, 1)), norm_of((3, 2, 1), (0, 0, 0), [0] * 6, RHO)
    near = still([0.005, 0.005, 0.005, 0, 0, 0])
    eps = size_of(norm, near)
    truth = size_of(norm, moved(body, near, 1))
    assert truth > eps * (1 + 1e-4)
    return truth, step(body, still([0] * 6), eps, 1, norm)[1]


TOP = (2, 1.5, 1), (0.3, 0.2, 0.5)


def drawn(seed):
    """A state, and jets around it."""
    chance = random.Random(seed)
    rows = [[chance.uniform(-1, 1) for _ in range(6)] for _ in verify.MONOMIALS]
    return rows[0], still(*rows)


def by_rounding_at_the_end(_):
    """At ten bits, of a step so short that all else is less."""
    state, begin = drawn(2)
    body, norm, few = body_of(*TOP), norm_of(*TOP, state, RHO), 10
    end, off = step(body, begin, 0, 2**-10, norm, few)
    return size_of(norm, difference(end, moved(body, begin, 2**-10))), off


#: How far a step of jets is off by one of its terms, and its bound; how many times that.
TERMS = {
    by_the_symmetric_part: 1.3,
    by_what_depends_on_xi: 2,
    by_a_guess_that_does_not_move: 3,
    by_what_is_quadratic_in_a_wide_start: 2,
    by_rounding_at_the_end: 20,
}


@pytest.mark.parametrize("term", TERMS)
def test_one_term_of_a_step_is_enough_and_not_slack(term, monkeypatch):
    truth, bound = term(monkeypatch)
    assert truth <= bound < TERMS[term] * truth


def test_all_jets_within_a_distance_are_held_with_their_weights():
    """For each coefficient there is one that is as far off as the bound, but for a factor."""
    norm = norm_of(*TOP, [1, 1, 1, 0, 0, 1], RHO)
    for m in range(len(verify.MONOMIALS)):
        for i in range(6):
            columns = [[0.0] * 6 for _ in verify.MONOMIALS]
            columns[m][i] = 1.0
            unit = jets_of(*columns)
            far = 1 / size_of(norm, unit)
            around = norm.around(still([0] * 6), arb(1))[i].parts[m]
            assert far <= float(around.rad()) < 6 * far
            assert around.contains(arb(0.999 * far))


def test_a_step_from_a_start_that_is_too_wide_is_refused():
    body, norm = body_of(*TOP), norm_of(*TOP, [1, 1, 1, 0, 0, 1], RHO)
    _, begin = drawn(0)
    step(body, begin, 1e-4, 2**-7, norm)
    with pytest.raises(verify.NotProved, match="the condition of the step"):
        step(body, begin, 100, 2**-7, norm)
