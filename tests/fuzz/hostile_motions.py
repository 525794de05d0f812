"""Events at double roots and at both ends, proven ones, bodies and units at extremes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import polhode
from polhode.dynamics.sections import jobs  # noqa: F401  (imported before memory is measured)
from polhode.scenes.shapes import SHAPES

Work = Callable[[], Any]
Words = list[str]

# -- events ---------------------------------------------------------------------------------------

#: Zeros that touch, that lie at the start or at the end, that pile up, that are none.
ZEROS = [
    *("t", "t-1", "t*t", "(t-1)*(t-1)", "t*(t-1)", "(t-0.5)**2", "(t-0.5)**3", "t-0.5", "1-t"),
    *("(t-0.5)**2-1e-30", "(t-0.5)**2+1e-30", "(t-0.5)**2-1e-12", "(t-0.5)*(t-0.5000000001)"),
    *(
        "p-0.3",
        "(p-0.3)**2",
        "q+0.4",
        "r-1.1",
        "gamma1-0.6",
        "(gamma3-0.8)**2",
        "gamma2",
        "gamma2**2",
    ),
    *("sin(1000*t)", "sin(t)", "cos(1e6*t)", "sin(3.14159265358979*t)", "sin(t)**2", "t**20"),
    *(
        "(t-1/3)**2*(t-2/3)**2",
        "1e300*(t-0.5)",
        "1e-300*(t-0.5)",
        "t-1e-300",
        "t+1e-300",
        "t-1e300",
    ),
    *(
        "sqrt(t)",
        "sqrt(1-t)",
        "1/(t-2)",
        "1/t",
        "1/(t-0.5)**2",
        "sqrt((t-0.5)**2)",
        "t-t+1",
        "p-p+1",
    ),
    *(
        "gamma1**2+gamma2**2+gamma3**2-1.0000001",
        "p*q*r",
        "p*gamma1+q*gamma2",
        "t-0.9999999999999999",
    ),
]


def event(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A run with hostile events, either direction in time; its times are looked at."""
    zeros = [random.choice(ZEROS) for _ in range(random.choice((1, 1, 2, 3)))]
    ways = [random.choice(("any", "rising", "falling")) for _ in zeros]
    stops = [random.random() < 0.2 for _ in zeros]
    events = tuple(
        polhode.Event(f"e{k}", *told) for k, told in enumerate(zip(zeros, ways, stops, strict=True))
    )
    number = random.choice(("double", "double", "double", "extended", "quad"))
    end = random.choice((1, 1, -1, 2, "0.5", "1e-3"))
    text = f"{number} to {end}: {zeros} {ways} {stops}"

    def run() -> None:
        found = polhode.integrate(replace(scene, events=events), number, at=[0, end], max_steps=500)
        for one in found.events:
            sizes = [abs(t) for t in one.times]
            assert sizes == sorted(sizes), f"events out of order: {sizes}"
            assert all(0 <= t <= abs(found.reached) for t in sizes), f"beyond the run: {sizes}"
            assert len(one.times) == len(one.states) == len(one.grazing)

    return text, run


def proof(random: Random, scene: polhode.Scene) -> tuple[str, Words]:
    """Proven events of the same kinds, none of them identically zero."""
    zeros = [zero for zero in ZEROS if "1e" not in zero and "1000*" not in zero]
    chosen = random.choice(zeros)
    text = Path("top.toml").read_text()
    Path("folder/in/proof.toml").write_text(f'{text}[[events]]\nname = "x"\nzero = "{chosen}"\n')
    words = ["reference", "folder/in/proof.toml", "--certified", "--events", "--digits", "12"]
    return chosen, [*words, "--at", random.choice(("1", "0,1", "0.5")), "--max-seconds", "5"]


# -- bodies and units -----------------------------------------------------------------------------

SIZES = [
    *("1e-300", "1e-150", "1e-30", "1e-9", "0", "1", "3/7", "pi", "1e9", "1e30", "1e150", "1e300")
]
SIZES += ["1e-4000", "1e4000", "-1", "sqrt(2)*1e-200", "nan", "1/0"]


def body(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A top of parts, lengths, masses, g and rates at extremes, shown and run a little."""
    wild = random.random() < 0.3
    unit = random.choice(SIZES[:12])

    def size() -> str:
        return random.choice(SIZES) if wild else f"{unit}*{random.choice(('1', '3', '1/7', '0.6'))}"

    parts_of = []
    for _ in range(random.choice((1, 1, 2))):
        given: dict[str, Any] = {"mass": size()}
        shape = random.choice([*SHAPES])
        for name in SHAPES[shape].needs:
            vector = name in ("size", "semi_axes")
            given[name] = [size() for _ in range(3)] if vector else size()
        if random.random() < 0.5:
            given["at"] = [size() for _ in range(3)]
        if random.random() < 0.05:
            given[random.choice(("radius", "height", "inner", "size", "mass"))] = size()
        parts_of.append((shape, given))
    start = {"angles": [0, "1/3", 0], "rates": [0, 0, size()]}
    more = {"g": size(), "end": size()}
    text = f"{parts_of} {start} {more}"

    def make() -> None:
        made = [polhode.Part(shape, **given) for shape, given in parts_of]
        top = polhode.top(parts=made, **start, **more)
        _ = repr(top), polhode.as_toml(top), top.regime if hasattr(top, "regime") else None
        polhode.integrate(top, max_steps=20)

    return text, make


def units(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A right scene whose lengths and times are scaled by enormous and tiny powers."""
    a, b = random.choice(range(-200, 201, 20)), random.choice(range(-80, 81, 8))
    moments = [
        f"{m}e{a}" for m in random.choice((["2", "3", "4"], ["1", "1", "0.5"], ["2", "2", "1"]))
    ]
    omega = [f"{w}e{b}" for w in ("0.3", "-0.4", "1.1")]
    weight = f"1e{a + 2 * b}"
    number = random.choice(("double", "extended", "quad"))
    text = f"{number}: moments {moments}, omega {omega}, weight {weight}"

    def run() -> None:
        body_of = polhode.Body.of_moments(moments, centre=[0, 0, 1], weight=weight)
        top = polhode.Scene(body_of, omega, ("0.6", 0, "0.8"), times=(f"1e{-b}",))
        found = polhode.integrate(top, number, max_steps=1000)
        plain = polhode.Scene(
            polhode.Body.of_moments(
                [m.partition("e")[0] for m in moments], centre=[0, 0, 1], weight=1
            ),
            ("0.3", "-0.4", "1.1"),
            ("0.6", 0, "0.8"),
            times=(1,),
        )
        right = polhode.integrate(plain, number, max_steps=1000)
        off = [
            abs(float(x) - float(y))
            for x, y in zip(found.states[0][3:], right.states[0][3:], strict=True)
        ]
        assert max(off) < 1e-13, f"gamma off by {max(off)}"

    return text, run
