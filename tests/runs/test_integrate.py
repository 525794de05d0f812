"""Integration: what enters heyoka, what comes out, and how a run ends."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.equations.forms import principal
from polhode.equations.system import System, system
from polhode.motion.outcomes import Outcome
from polhode.numbers import conversion, number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, NumberType
from polhode.taylor.backend import defaults, heyoka_numbers
from polhode.taylor.backend.heyoka_numbers import as_fraction
from polhode.taylor.integrator.build import build
from polhode.taylor.integrator.stepping import Integrator
from shared.commands import STEPPING
from shared.motions import heavy_file, in_other_units, same_bits
from shared.policies import change_policy

NUMBERS = [DOUBLE, EXTENDED, QUAD, number_types.mp(50), NumberType("mp", 333)]

HEAVY = """
schema = 1
[body]
moments = ["1/3", "2/7", "3/11"]
centre = ["1/10", "1/7", "1/3"]
weight = "9.81"
[start]
omega = [0.3, 0.2, 1.1]
gamma = ["2/7", "3/7", "6/7"]
[run]
end = 1
"""


def heavy(outputs: tuple[str, ...] = ()) -> polhode.Scene:
    from polhode.scenes import scene_file

    return replace(scene_file.parse(HEAVY), outputs=outputs)


def integrator(scene: polhode.Scene, number: NumberType) -> tuple[System, Integrator]:
    whole = system(scene, scene.outputs)
    return whole, build(whole, number)


def constants_of(decomposition: object, bits: int) -> set[Fraction]:
    """Every number that stands in a Taylor decomposition, exactly."""
    found = set()
    with mpmath.workprec(bits):
        pending = [expression for expression, _ in decomposition]
        while pending:
            expression = pending.pop()
            text = str(expression)
            for token in text.replace("(", " ").replace(")", " ").replace(",", " ").split():
                try:
                    found.add(exactly(mpmath.mpf(token)))
                except ValueError:
                    continue
    return found


@pytest.mark.sample(4)
@pytest.mark.parametrize("number", NUMBERS, ids=lambda n: f"{n.name}{n.bits}")
@pytest.mark.parametrize("outputs", [(), ("attitude",), ("angles",)])
def test_every_constant_in_the_compiled_equations_is_the_rounded_exact_one(number, outputs):
    """heyoka folds constants of its own in double; none may be there but ours.

    Beside them stand 0, ±1, ½ and 2, and the power of two that angles are divided by.  Ours are
    its parameters: in this order, after three of events.
    """
    run, built = integrator(heavy(outputs), number)
    given = [as_fraction(x, number) for x in built.heyoka.pars]
    assert given == [0, 0, 0, *(number.rounded(x) for x in run.coefficients.values())]
    plain = {Fraction(x) for x in (0, 1, Fraction(1, 2), 2)}
    if outputs == ("angles",):
        plain.add(Fraction(1, defaults.of(number).divisor))
    found = constants_of(built.decomposition, number.bits)
    assert not {x for x in found if abs(x) not in plain}


def test_a_constant_folded_in_double_would_be_found():
    """The scan above can fail: dividing by a Python float folds in double."""
    import heyoka as hy

    x = hy.make_vars("x")
    third = hy.expression(hy.real(1, 237)) / 3.0
    built = hy.taylor_adaptive(
        [(x, third * x)], [hy.real(1, 237)], fp_type=hy.real, prec=237, compact_mode=True
    )
    found = constants_of(built.decomposition, 237)
    assert number_types.mp(70).rounded(Fraction(1, 3)) not in found


@pytest.mark.parametrize(
    ("body", "terms"),
    [
        ("moments = [1, 2, 3]\nweight = 0", {"p.qr", "q.rp", "r.pq"}),
        ("moments = [2, 2, 3]\nweight = 0", {"p.qr", "q.rp"}),
        ("moments = [2, 2, 2]\nweight = 0", set()),
        ("moments = [1, 1, 1]\ncentre = [0, 0, 1]\nweight = 2", {"p.gamma2", "q.gamma1"}),
        (
            "moments = [2, 2, 1]\ncentre = [1, 0, 0]\nweight = 1",
            {"p.qr", "q.rp", "q.gamma3", "r.gamma2"},
        ),
    ],
)
def test_no_vanishing_coefficient_enters(body, terms):
    from polhode.scenes import scene_file

    text = f"schema = 1\n[body]\n{body}\n[start]\nomega = [1, 2, 3]\ngamma = [0, 0, 1]\n"
    assert set(principal.coefficients(scene_file.parse(text).body)) == terms


def test_a_torque_free_scene_without_gamma_has_three_equations():
    scene = polhode.load("euler/no-gamma")
    run, built = integrator(scene, DOUBLE)
    assert run.names == ("p", "q", "r")
    assert len(built.heyoka.state) == 3
    assert polhode.integrate(scene).states.shape[1] == 3


@pytest.mark.parametrize("number", NUMBERS, ids=lambda n: f"{n.name}{n.bits}")
def test_numbers_enter_and_leave_without_loss(number):
    """scalar() is the nearest number of the type, and what heyoka holds reads back bit for bit."""
    for x in (Fraction(1, 3), Fraction(-22, 7), Fraction(10) ** 20 / 3, Fraction(1, 10**25)):
        value = heyoka_numbers.scalar(x, number)
        with mpmath.workprec(number.bits):
            back = exactly(value) if number.bits <= 64 else exactly(mpmath.mpf(str(value)))
        assert back == number.rounded(x)
        assert abs(back - x) <= abs(x) * number.eps / 2


@pytest.mark.sample(2)
@pytest.mark.parametrize("number", NUMBERS[:4], ids=lambda n: n.name)
def test_output_times_never_change_the_steps(number):
    scene = polhode.load("general/asymmetric-chaotic")
    few = polhode.integrate(scene, number, at=[10])
    many = polhode.integrate(scene, number, at=[*range(1, 10), Fraction(19, 2), 10])
    assert few.steps == many.steps
    assert [exactly(x) for x in few.states[-1]] == [exactly(x) for x in many.states[-1]]


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED])
def test_chunks_take_the_same_steps_bit_for_bit(number, monkeypatch):
    """A run is cut into chunks so that Ctrl-C is heard; the steps are those of an uncut run."""
    scene = polhode.load("euler/largest-axis")
    whole = polhode.integrate(scene, number, at=[1000], project=False)
    change_policy(monkeypatch, chunk=7)
    cut = polhode.integrate(scene, number, at=[1000], project=False)
    assert cut.steps == whole.steps
    difference = max(
        abs(exactly(x) - exactly(y)) for x, y in zip(cut.states[0], whole.states[0], strict=True)
    )
    assert difference <= 4 * number.eps  # the last step alone is clamped to a rounded time


def test_the_states_are_those_of_the_bare_integrator_bit_for_bit():
    """The same equations in bare heyoka, coefficients as parameters, give the same doubles."""
    import heyoka as hy

    p, q, r, g1, g2, g3 = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    bare = hy.taylor_adaptive(
        [
            (p, hy.par[0] * (q * r)),
            (q, hy.par[1] * (r * p)),
            (r, hy.par[2] * (p * q)),
            (g1, r * g2 - q * g3),
            (g2, p * g3 - r * g1),
            (g3, q * g1 - p * g2),
        ],
        [0.3, 0.4, 1.1, 2 / 7, 3 / 7, 6 / 7],
        pars=[-0.5, 2 / 3, -0.25],
    )
    from polhode.scenes import scene_file

    ours = polhode.integrate(
        scene_file.parse(heavy_file("1000", samples=11, weight="0")),
        project=False,
    )
    theirs = bare.propagate_grid(np.linspace(0, 1000, 11))
    assert theirs[3] == ours.steps
    assert np.array_equal(theirs[-1], ours.states)


@pytest.mark.parametrize("exponent", [-40, -7, 3, 60])
def test_scaling_a_scene_by_powers_of_two_changes_no_bit(exponent):
    """Moments times 2**a, time times 2**b, weight to match: the same bits, shifted."""
    scene = heavy()
    other = in_other_units(scene, exponent)
    assert same_bits(polhode.integrate(scene), polhode.integrate(other), exponent)


def test_forward_and_back_returns_to_the_start():
    """To t = 10 and back from the state reached: the start again, to what rounding leaves."""
    from polhode.numbers import exact

    there = polhode.integrate("general/asymmetric-chaotic", at=[10])
    reached = [exactly(x) for x in there.states[0]]
    length = exact.sqrt(sum(x * x for x in reached[3:]))
    scene = replace(
        there.scene, omega=tuple(reached[:3]), gamma=tuple(x / length for x in reached[3:])
    )
    back = polhode.integrate(scene, at=[-10])
    error = max(abs(exactly(x) - y) for x, y in zip(back.states[0], there.scene.start, strict=True))
    assert 0 < error < 300 * DOUBLE.eps


# -- outcomes ---------------------------------------------------------------------------------


def test_step_limit_is_an_outcome_with_advice():
    run = polhode.integrate("euler/largest-axis", max_steps=50)
    assert run.outcome is Outcome.STEP_LIMIT
    assert not run.outcome.done
    assert run.steps <= 50
    assert 0 < run.reached < run.scene.end
    assert len(run.times) == len(run.states) < len(run.scene.times)
    assert "--max-steps" in run.outcome.advice


def test_an_end_beyond_the_step_limit_is_refused_at_once():
    began = time.process_time()
    run = polhode.integrate("euler/largest-axis", at=[Fraction(10) ** 30])
    assert run.outcome is Outcome.STEP_LIMIT
    assert time.process_time() - began < 20  # a hang would take hours; no timing is judged here


def test_a_state_that_becomes_infinite_is_an_outcome(monkeypatch):
    scene = polhode.load("euler/attitude")  # starts at a pole, where psi' is 0/0
    monkeypatch.setattr(polhode.Scene, "starts_at_pole", False)  # and is led over it otherwise
    run = polhode.integrate(replace(scene, outputs=("angles",)), at=[1])
    assert run.outcome is Outcome.NON_FINITE
    assert run.outcome.cause
    assert "angles" in run.outcome.advice


@pytest.mark.parametrize("number", ["double", "quad"])
def test_ctrl_c_ends_a_run_within_a_second_and_reports_what_was_reached(number):
    sent: list[float] = []

    def press() -> None:
        sent.append(time.process_time())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.2, press)

    def told(fraction: float, count: int) -> None:
        if fraction > 0 and timer.ident is None:  # a loaded machine may take long to begin
            timer.start()

    scene = polhode.load("euler/largest-axis")
    times = [Fraction(k) for k in range(100, 40_000_000, 100_000)]
    run = polhode.integrate(scene, number, at=times, max_steps=10**9, progress=told)
    ended = time.process_time()
    timer.join()
    assert run.outcome is Outcome.INTERRUPTED
    assert run.reached > 0
    assert len(run.times) == len(run.states) < len(times)
    assert all(t <= run.reached for t in run.times)
    assert ended - sent[0] < 5  # of processor time; the whole run would take minutes


def test_ctrl_c_of_the_program_exits_130_and_writes_nothing(tmp_path):
    path = tmp_path / "x.csv"
    asked = ["run", "euler/largest-axis", "--at", "100,1e10", "--max-steps", "1000000000000"]
    with subprocess.Popen(
        [sys.executable, "-c", STEPPING, *asked, "-o", str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout.readline() == "steps\n"
        program.send_signal(signal.SIGINT)
        _, said = program.communicate(timeout=60)  # the run itself would take hours
    assert program.returncode == 130
    assert "interrupted" in said
    assert not list(tmp_path.iterdir())


def test_every_outcome_has_a_cause_and_every_failure_advice():
    for outcome in Outcome:
        assert outcome.cause
        assert outcome.done or outcome.advice


# -- refusals ---------------------------------------------------------------------------------


def test_times_that_round_to_the_same_number_are_refused():
    with pytest.raises(polhode.BadInput, match="differ when rounded to double"):
        polhode.integrate("euler/largest-axis", at=[1, 1 + Fraction(1, 10**20)])
    run = polhode.integrate("euler/largest-axis", "quad", at=[1, 1 + Fraction(1, 10**20)])
    assert run.times[1] > run.times[0]


def test_a_tolerance_below_eps_is_refused():
    with pytest.raises(polhode.BadInput, match="eps"):
        polhode.integrate("euler/largest-axis", tol=1e-17)
    loose = polhode.integrate("euler/largest-axis", at=[10], tol="1e-8")
    assert 6 < polhode.compare(loose).worst < 11
    assert not loose.at_full_tolerance


def test_numbers_outside_the_range_of_a_type_are_refused():
    scene = polhode.load("euler/largest-axis")
    tiny = replace(scene, omega=(Fraction(1, 10**350), Fraction(1), Fraction(1)))
    with pytest.raises(polhode.BadInput, match="range of double"):
        polhode.integrate(tiny, at=[1])
    assert polhode.integrate(tiny, "quad", at=[1]).outcome.done


def test_digits_choose_the_type_and_a_narrower_one_is_refused():
    scene = polhode.load("euler/largest-axis").at((Fraction(1),))
    chosen = [polhode.integrate(scene, digits=d).number for d in (10, 15, 16, 18, 25, 34, 50)]
    assert [n.name for n in chosen] == [
        *("double", "extended", "extended", "quad", "quad", "mp", "mp")
    ]
    assert chosen[-1].most_digits > 50
    said = "^euler/largest-axis: digits = 30: expected fewer in double; quad holds them$"
    with pytest.raises(polhode.BadInput, match=said):
        polhode.integrate(scene, "double", digits=30)


def test_a_machine_without_the_80_bit_type_refuses_it_and_goes_on_to_quad(monkeypatch):
    monkeypatch.setattr(number_types, "extended_here", lambda: False)
    with pytest.raises(polhode.BadInput, match="no 64 bits here"):
        polhode.integrate("euler/largest-axis", "extended", at=[1])
    assert polhode.integrate("euler/largest-axis", digits=16, at=[1]).number is QUAD


# -- attitude and angles ----------------------------------------------------------------------


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name", ["euler/attitude", "euler/turned-axes", "general/asymmetric-regular"]
)
def test_attitude_of_a_run_carries_gamma(name):
    """The third row of R is gamma, and the quaternion keeps length one, to a few eps per step."""
    scene = replace(polhode.load(name), outputs=("attitude",))
    run = polhode.integrate(scene, "quad", at=[1, 5])
    for row, (q0, q1, q2, q3) in zip(run.states, run.attitude, strict=True):
        with mpmath.workprec(113):
            gamma = (
                2 * (q1 * q3 - q0 * q2),
                2 * (q2 * q3 + q0 * q1),
                q0**2 - q1**2 - q2**2 + q3**2,
            )
            error = max(abs(a - b) for a, b in zip(gamma, row[3:], strict=True))
            length = abs(q0**2 + q1**2 + q2**2 + q3**2 - 1)
        assert max(error, length) < 100 * mpmath.mpf(2) ** -112


def test_attitude_and_angles_of_a_run_are_those_of_the_closed_form():
    scene = replace(polhode.load("euler/largest-axis"), outputs=("angles", "attitude"))
    truth = polhode.reference(scene)
    run = polhode.integrate(scene, "quad", at=[1, 10, 50])
    for mine, exact in (
        (run.attitude, truth.attitude(run.times, 34)),
        (run.angles, truth.angles(run.times, 34)),
    ):
        with mpmath.workprec(150):
            worst = max(
                abs(x - y)
                for a, b in zip(mine, exact, strict=True)
                for x, y in zip(a, b, strict=True)
            )
        assert 30 < -mpmath.log10(worst) < 36


def test_psi_and_phi_are_continuous_over_many_turns():
    scene = replace(polhode.load("euler/largest-axis"), outputs=("angles",))
    run = polhode.integrate(scene, at=[Fraction(k, 10) for k in range(1, 1000)])
    psi, _, phi = (np.array(column) for column in zip(*run.angles, strict=True))
    assert np.max(np.abs(np.diff(psi))) < 1.5
    assert np.max(np.abs(np.diff(phi))) < 1.5
    assert max(abs(psi[-1]), abs(phi[-1])) > 4 * math.pi


@pytest.mark.sample(2)
@pytest.mark.parametrize("number", NUMBERS[:4], ids=lambda n: n.name)
@pytest.mark.parametrize("gamma", [(0, 0, 1), (0, 0, -1)], ids=["upper", "lower"])
@pytest.mark.parametrize("end", [3, -3])
def test_angles_of_a_start_at_a_pole_begin_at_their_one_sided_limits(number, gamma, end):
    """psi and phi are undefined at t = 0, then the closed form's mod 2 pi."""
    scene = replace(
        polhode.load("euler/attitude"),
        gamma=tuple(Fraction(g) for g in gamma),
        outputs=("angles", "attitude"),
    )
    run = polhode.integrate(scene, number, at=[0, Fraction(end, 100), end])
    assert run.angles[0][0] is None
    assert run.angles[0][2] is None
    exact = polhode.reference(scene).angles(run.times, 60)
    with mpmath.workprec(200):
        for mine, true in zip(run.angles[1:], exact[1:], strict=True):
            for k, (x, y) in enumerate(zip(mine, true, strict=True)):
                gap = conversion.to_mpf(exactly(x), 200) - y
                if k != 1:
                    gap -= 2 * mpmath.pi * mpmath.nint(gap / (2 * mpmath.pi))
                assert abs(gap) < 2000 * mpmath.mpf(2) ** (1 - number.bits)
        first, start = run.angles[1], conversion.to_mpf(scene.psi, 200)
        sign = 1 if gamma[2] > 0 else -1
        kept = conversion.to_mpf(exactly(first[0]) + sign * exactly(first[2]), 200)
        assert abs(kept - start) < 0.1  # psi ± phi stays continuous over the pole


def test_a_body_that_stays_at_the_pole_has_no_psi_and_phi():
    scene = replace(
        polhode.load("euler/largest-axis"),
        omega=(Fraction(0), Fraction(0), Fraction(2)),
        gamma=(Fraction(0), Fraction(0), Fraction(1)),
        outputs=("angles", "attitude"),
    )
    run = polhode.integrate(scene, at=[0, 1, 2])
    assert [row[0] for row in run.angles] == [row[2] for row in run.angles] == [None] * 3
    assert [float(row[1]) for row in run.angles] == [0.0] * 3
    assert run.attitude.shape == (3, 4)
