"""Precision is polhode's own: threads do not share it, and the caller's is neither read nor set."""

from __future__ import annotations

import dis
import inspect
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from random import Random
from typing import Any

import flint
import mpmath
import pytest

import polhode
from polhode.common import interrupts
from polhode.common.interrupts import TooLong
from polhode.numbers import flint_context, mpmath_context
from shared.tools import tiers

FAMILIES = (
    *("euler/separatrix", "lagrange/nutation", "kovalevskaya/generic", "hess/loxodrome"),
    *("goryachev-chaplygin/two-frequencies", "grioli/precession"),
)
THREADS = 16


@pytest.fixture(autouse=True)
def callers() -> Iterator[None]:
    """The precisions of a caller, and a quick change of threads."""
    before, interval = (mpmath.mp.prec, flint.ctx.prec), sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)
    mpmath.mp.prec, flint.ctx.prec = before


def answer(question: tuple[str, int]) -> list[Any]:
    """A new reference's rows and attitude; raw, for a comparison to the bit."""
    name, digits = question
    reference = polhode.reference(name)
    rows = reference.at(["0.7", 3], digits)
    if name.startswith(("euler", "lagrange")):
        rows += reference.attitude(["0.7"], digits)
    return [x._mpf_ for row in rows for x in row]


@pytest.mark.slow
def test_threads_of_mixed_precision_answer_as_one_does():
    """Of 8 threads 4 answers in 72 were wrong, and the caller's precision was left changed.

    Another thread of the caller's changes precision meanwhile.
    """
    questions = [(name, digits) for name in FAMILIES for digits in (15, 20, 33)]
    questions += [(name, digits) for name in FAMILIES[:2] for digits in (77, 300)]
    Random(12).shuffle(questions)
    alone = [answer(q) for q in questions]
    finished, random = threading.Event(), Random(1)

    def busy() -> None:
        while not finished.is_set():
            mpmath.mp.dps = random.randint(3, 200)
            _ = mpmath.sqrt(2) + mpmath.pi + mpmath.exp(mpmath.mpf(1) / 3)
        mpmath.mp.prec = 71

    caller = threading.Thread(target=busy)
    caller.start()
    flint.ctx.prec = 53
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            together = list(pool.map(answer, questions))
    finally:
        finished.set()
        caller.join()
    assert together == alone
    assert (mpmath.mp.prec, flint.ctx.prec) == (71, 53)


def test_one_reference_may_be_asked_by_many_threads():
    shared_reference, fresh = (polhode.reference("lagrange/nutation") for _ in "ab")
    questions = [(t, digits) for t in (1, 2, 5, 40) for digits in (15, 60, 200)]
    with ThreadPoolExecutor(THREADS) as pool:
        together = list(pool.map(lambda q: shared_reference.at([q[0]], q[1])[0], questions))
    assert together == [fresh.at([t], digits)[0] for t, digits in questions]


def whole_run() -> Any:
    scene = polhode.load("lagrange/nutation").at([0, 1])
    run = polhode.integrate(replace(scene, outputs=("angles", "attitude", "hodographs")), "quad")
    own = run.states, run.angles, run.attitude, run.hodographs, run(0.5), run.drift
    return own, polhode.compare(run).digits


def facts() -> Any:
    reference = polhode.reference("lagrange/nutation")
    rows = [getattr(reference, q)([1], 40) for q in ("at", "angles", "attitude", "hodographs")]
    values = reference.period, dict(reference.frequencies), reference.error([1], 20)
    return rows, values, polhode.reference("kovalevskaya/generic").curve


QUESTIONS = {
    "a run": whole_run,
    "a reference": facts,
    "a proof": lambda: polhode.certify("lagrange/nutation", at=[1], digits=20).midpoints,
    "a sweep": lambda: (
        polhode.integrate_many(
            polhode.load("lagrange/nutation").at([0, 1]),
            {"start.omega[1]": [1, 2]},
            number="quad",
        ).states
    ),
}


def leaves(value: Any) -> Iterator[Any]:
    """The numbers in nested values."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple)) or getattr(value, "ndim", 0):
        for x in value:
            yield from leaves(x)
    else:
        yield value


@pytest.mark.parametrize("question", tiers(["a run", "a proof"], ["a reference", "a sweep"]))
def test_answers_are_ordinary_numbers_whatever_the_callers_precision(question):
    answers = {}
    for bits in (20, 53, 400):
        mpmath.mp.prec = bits
        answers[bits] = [*leaves(QUESTIONS[question]())]
        assert mpmath.mp.prec == bits
    for x in answers[20]:
        assert isinstance(x, mpmath.mpf) or not hasattr(x, "_mpf_")
    raw = [
        [getattr(x, "_mpf_", x) for x in numbers if not callable(x)] for numbers in answers.values()
    ]
    assert raw[0] == raw[1] == raw[2]


@pytest.mark.slow
@pytest.mark.parametrize("context", [mpmath_context.mpmath])
def test_an_alarm_at_any_moment_leaves_the_lock_to_others(context):
    """The alarm of `show` came between taking the lock and noting it: other threads waited."""
    own = {module.__file__ for module in (mpmath_context, flint_context, interrupts)}

    def after_calls(code: Any) -> set[int]:
        """Where CPython may run a signal's handler, beside the beginning of a function."""
        pairs = pairwise(dis.get_instructions(code))
        return {y.offset for x, y in pairs if x.opname.startswith("CALL")}

    def interrupted(step: int) -> bool:
        left = step

        def trace(frame: Any, event: str, _: object) -> Any:
            nonlocal left
            code = frame.f_code
            if code.co_filename not in own:
                return None
            frame.f_trace_opcodes = True
            begins = event == "call" and not code.co_flags & inspect.CO_GENERATOR
            if begins or (event == "opcode" and frame.f_lasti in after_calls(code)):
                left -= 1
                if left == 0:
                    raise TooLong
            return trace

        sys.settrace(trace)
        try:
            with context.workprec(100):
                pass
        except TooLong:
            return True
        finally:
            sys.settrace(None)
        return False

    lock = mpmath_context.PRECISION.bare
    with ThreadPoolExecutor(1) as pool:
        step = 1
        while interrupted(step):
            assert pool.submit(lock.acquire, timeout=10).result(), step
            pool.submit(lock.release).result()
            step += 1
    assert step > 5
