"""One small question to each of polhode's verbs, and its answer to the bit."""

import dataclasses
import functools
import multiprocessing
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from enum import Enum
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from polhode.numbers.conversion import ExactNumbers
from polhode.numbers.exact import Irrational, rounded

GENERAL = "general/asymmetric-regular"
THREADS = 16
PATIENCE = 600.0  # seconds, for what ends in a few if at all


def bits(value: Any) -> Any:
    """A value as plain data that is equal only where every bit is, nan and the sign of 0 too."""
    if value is None or isinstance(value, (str, int, Fraction, Enum)):
        return value
    if (raw := getattr(value, "_mpf_", None)) is not None:
        return tuple(map(int, raw))
    if (raw := getattr(value, "_mpc_", None)) is not None:
        return tuple(tuple(map(int, part)) for part in raw)
    if isinstance(value, Irrational):
        return rounded(value, 190)
    if isinstance(value, complex):
        return value.real.hex(), value.imag.hex()
    if isinstance(value, np.longdouble):  # whose bytes are padded with anything
        high = float(value)
        return high.hex(), float(value - np.longdouble(high)).hex()
    if isinstance(value, (float, np.floating)):
        return float(value).hex()
    if isinstance(value, np.ndarray):
        flat = value.ravel()
        plain = value.dtype != object and value.dtype != np.longdouble
        return value.shape, flat.tobytes() if plain else [bits(x) for x in flat]
    if isinstance(value, dict):
        return [(key, bits(x)) for key, x in value.items()]
    if isinstance(value, (list, tuple, ExactNumbers)):
        return [bits(x) for x in value]
    if dataclasses.is_dataclass(value):
        names = [f.name for f in dataclasses.fields(value) if f.compare]
        return [(name, bits(getattr(value, name))) for name in names]
    raise TypeError(f"no plain data: {type(value)}")


def integrate() -> Any:
    scene = dataclasses.replace(polhode.load("lagrange/nutation"), outputs=("angles", "attitude"))
    run = polhode.integrate(scene, at=[0, 1, 2])
    return run.states, run.angles, run.attitude, run.drift, run.expected.digits, run(0.7)


def quad() -> Any:
    run = polhode.integrate("lagrange/nutation", "quad", at=[0, 1])
    return run.states, run.drift


def events() -> Any:
    event = polhode.Event("level", "gamma1")
    scene = dataclasses.replace(polhode.load(GENERAL), events=(event,))
    run = polhode.integrate(scene, at=[0, 5])
    return [crossings.times for crossings in run.events], run.states


def reference() -> Any:
    lagrange = polhode.reference("lagrange/nutation")
    euler = polhode.reference("euler/separatrix")
    return lagrange.at([1, 3], 50), lagrange.angles([1], 40), euler.at(["0.7"], 200)


def enclosed() -> Any:
    return polhode.reference(GENERAL).at([1], 25)


def certify() -> Any:
    enclosure = polhode.certify(GENERAL, at=[1], digits=20)
    return enclosure.midpoints, enclosure.fewest


def compare() -> Any:
    judged = polhode.compare(polhode.integrate("lagrange/nutation", at=[0, 1, 2]))
    return judged.digits, judged.limit, judged.inputs


def levels() -> Any:
    surfaces = polhode.levels(GENERAL)
    return surfaces.curves, surfaces.marks, surfaces.exact, surfaces.here


def section() -> Any:
    crossings = polhode.section(GENERAL, grid=(2, 2), crossings=2, workers=1)
    return crossings.states, crossings.times, crossings.outcomes


def chaos_map() -> Any:
    picture = polhode.chaos_map(GENERAL, (2, 2), end=10, workers=1)
    return picture.fli, picture.growth


def orbit() -> Any:
    periodic = polhode.orbit("grioli/precession")
    return periodic.multipliers, periodic.residue, periodic.period


def frequencies() -> Any:
    spectrum = polhode.frequencies("lagrange/nutation", of=["p+iq"], end=20)
    return spectrum.lines


def integrate_many() -> Any:
    ensemble = polhode.integrate_many(GENERAL, {"start.omega[1]": "0:1:5"}, at=[0, 1, 2], workers=1)
    return ensemble.states, ensemble.drift, ensemble.steps


def reduce_many() -> Any:
    reductions = polhode.reduce_many(
        GENERAL, {"start.omega[1]": "0:1:5"}, ["smallest gamma3", "lyapunov"], at=[0, 5], workers=1
    )
    return [reductions[name] for name in reductions.names]


def lyapunov() -> Any:
    exponent = polhode.lyapunov(polhode.load(GENERAL), max_steps=400)
    return exponent


def conditioning() -> Any:
    condition = polhode.conditioning(polhode.load(GENERAL).at([0, 1, 2]))
    return condition.kappa


def show() -> Any:
    scene = polhode.load("grioli/precession")
    return polhode.as_toml(scene), scene.integrals, polhode.reference(scene).conditions


VERBS: dict[str, Callable[[], Any]] = {
    f.__name__: f
    for f in (
        *(integrate, quad, events, reference, enclosed, certify, compare, levels, section),
        *(chaos_map, orbit, frequencies, integrate_many, reduce_many, lyapunov, conditioning),
        show,
    )
}


def answer(name: str) -> Any:
    """What a verb says, to the bit."""
    return bits(VERBS[name]())


alone = functools.cache(answer)


def together(names: Sequence[str], jobs: int) -> set[str]:
    """Ask so many times in threads: the verbs whose answers differ from those of one thread."""
    waiting, wrong = deque(list(names) * (jobs // len(names))), set()

    def work() -> None:
        while True:
            try:
                name = waiting.popleft()
            except IndexError:
                return
            try:
                if answer(name) != alone(name):
                    wrong.add(name)
            except BaseException as fault:
                wrong.add(f"{name}: {fault!r}")

    for name in names:
        alone(name)
    threads = [threading.Thread(target=work, daemon=True) for _ in range(THREADS)]
    for thread in threads:
        thread.start()
    until = time.monotonic() + PATIENCE
    for thread in threads:
        thread.join(max(0.0, until - time.monotonic()))
    left = sum(thread.is_alive() for thread in threads)
    assert left == 0, f"{left} threads wait for each other: {names}"
    return wrong


def in_pool(start: str, names: Sequence[str]) -> list[Any]:
    """The answers of a pool of two processes that begin in one of Python's ways."""
    with multiprocessing.get_context(start).Pool(2) as pool:
        return pool.map_async(answer, names, chunksize=1).get(PATIENCE)
