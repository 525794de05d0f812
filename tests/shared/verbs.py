"""One small question to each of polhode's verbs, and its answer to the bit."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from enum import Enum
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from polhode.numbers.exact import Irrational, rounded
from polhode.numbers.exact_sequences import ExactNumbers

GENERAL = "general/asymmetric-regular"


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
    return [found.times for found in run.events], run.states


def reference() -> Any:
    lagrange = polhode.reference("lagrange/nutation")
    euler = polhode.reference("euler/separatrix")
    return lagrange.at([1, 3], 50), lagrange.angles([1], 40), euler.at(["0.7"], 200)


def enclosed() -> Any:
    return polhode.reference(GENERAL).at([1], 25)


def certify() -> Any:
    found = polhode.certify(GENERAL, at=[1], digits=20)
    return found.midpoints, found.fewest


def compare() -> Any:
    judged = polhode.compare(polhode.integrate("lagrange/nutation", at=[0, 1, 2]))
    return judged.digits, judged.limit, judged.inputs


def levels() -> Any:
    found = polhode.levels(GENERAL)
    return found.curves, found.marks, found.exact, found.here


def section() -> Any:
    found = polhode.section(GENERAL, grid=(2, 2), crossings=2, workers=1)
    return found.states, found.times, found.outcomes


def chaos_map() -> Any:
    found = polhode.chaos_map(GENERAL, (2, 2), end=10, workers=1)
    return found.fli, found.growth


def orbit() -> Any:
    found = polhode.orbit("grioli/precession")
    return found.multipliers, found.residue, found.period


def frequencies() -> Any:
    found = polhode.frequencies("lagrange/nutation", of=["p+iq"], end=20)
    return found.lines


def integrate_many() -> Any:
    found = polhode.integrate_many(GENERAL, {"start.omega[1]": "0:1:5"}, at=[0, 1, 2], workers=1)
    return found.states, found.drift, found.steps


def reduce_many() -> Any:
    found = polhode.reduce_many(
        GENERAL, {"start.omega[1]": "0:1:5"}, ["smallest gamma3", "lyapunov"], at=[0, 5], workers=1
    )
    return [found[name] for name in found.names]


def lyapunov() -> Any:
    found = polhode.lyapunov(polhode.load(GENERAL), max_steps=400)
    return found


def conditioning() -> Any:
    found = polhode.conditioning(polhode.load(GENERAL).at([0, 1, 2]))
    return found.kappa


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
