"""Events at double roots and at both ends, proven ones, bodies at extremes, as strategies."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from hypothesis import strategies as st

import polhode
from fuzz.cases import FREE, Case, of, several, top
from polhode.scenes.shapes import SHAPES

#: Zeros that touch, that lie at the start or at the end, that pile up, that are none.
ZEROS = (
    """
t; t-1; t*t; (t-1)*(t-1); t*(t-1); (t-0.5)**2; (t-0.5)**3; t-0.5; 1-t; t**20; (t-0.5)**2-1e-30
(t-0.5)**2+1e-30; (t-0.5)**2-1e-12; (t-0.5)*(t-0.5000000001); p-0.3; (p-0.3)**2; q+0.4; r-1.1
gamma1-0.6; (gamma3-0.8)**2; gamma2; gamma2**2; sin(1000*t); sin(t); cos(1e6*t); sin(t)**2
sin(3.14159265358979*t); (t-1/3)**2*(t-2/3)**2; 1e300*(t-0.5); 1e-300*(t-0.5); t-1e-300; t+1e-300
t-1e300; sqrt(t); sqrt(1-t); 1/(t-2); 1/t; 1/(t-0.5)**2; sqrt((t-0.5)**2); t-t+1; p-p+1; p*q*r
gamma1**2+gamma2**2+gamma3**2-1.0000001; p*gamma1+q*gamma2; t-0.9999999999999999
""".strip()
    .replace("\n", "; ")
    .split("; ")
)


@st.composite
def event(draw: st.DrawFn) -> Case:
    """A run with hostile events, either direction in time; its times are looked at."""
    ways = of(("any", "rising", "falling"))
    events = tuple(
        polhode.Event(f"e{k}", draw(of(ZEROS)), draw(ways), draw(st.integers(0, 4)) == 0)
        for k in draw(several(3))
    )
    number = draw(of(("double", "double", "double", "extended", "quad")))
    end = draw(of((1, 1, -1, 2, "0.5", "1e-3")))

    def run() -> None:
        scene = replace(top(), events=events)
        result = polhode.integrate(scene, number, at=[0, end], max_steps=500)
        for crossings in result.events:
            sizes = [abs(t) for t in crossings.times]
            assert sizes == sorted(sizes), f"events out of order: {sizes}"
            assert all(0 <= t <= abs(result.reached) for t in sizes), f"beyond the run: {sizes}"
            assert len(crossings.times) == len(crossings.states) == len(crossings.grazing)

    return Case(f"{number} to {end}: {events}", {}, run)


@st.composite
def proof(draw: st.DrawFn) -> Case:
    """Proven events of the same kinds, none of them identically zero."""
    zero = draw(of(z for z in ZEROS if "1e" not in z and "1000*" not in z))
    text = f'{FREE}[[events]]\nname = "x"\nzero = "{zero}"\n'
    words = ["certify", "case.toml", "--events", "--digits", "12"]
    words += ["--at", draw(of(("1", "0,1", "0.5"))), "--max-seconds", "5"]
    return Case(zero, {"case.toml": text.encode()}, words)


SIZES = ["1e-300", "1e-150", "1e-30", "1e-9", "0", "1", "3/7", "pi", "1e9", "1e30", "1e150"]
WILD = [*SIZES, "1e300", "1e-4000", "1e4000", "-1", "sqrt(2)*1e-200", "nan", "1/0"]


@st.composite
def body(draw: st.DrawFn) -> Case:
    """A top of parts, lengths, masses, g and rates at extremes, shown and run a little."""
    unit = draw(of(SIZES))
    sizes = draw(of((of(WILD), of(f"{unit}*{x}" for x in ("1", "3", "1/7", "0.6")))))
    three = st.lists(sizes, min_size=3, max_size=3)
    parts = []
    for _ in draw(several(2)):
        shape = draw(of(SHAPES))
        keys: dict[str, Any] = {"mass": draw(sizes)}
        for name in SHAPES[shape].needs:
            keys[name] = draw(three if name in ("size", "semi_axes") else sizes)
        if draw(st.booleans()):
            keys["at"] = draw(three)
        if draw(st.integers(0, 19)) == 0:
            keys[draw(of(("radius", "height", "inner", "size", "mass")))] = draw(sizes)
        parts.append((shape, keys))
    more = {"rates": [0, 0, draw(sizes)], "g": draw(sizes), "end": draw(sizes)}

    def make() -> None:
        solids = [polhode.Part(shape, **keys) for shape, keys in parts]
        scene = polhode.top(parts=solids, angles=[0, "1/3", 0], **more)
        _ = repr(scene), polhode.as_toml(scene)
        polhode.integrate(scene, max_steps=20)

    return Case(f"{parts} {more}", {}, make)


#: Moments, centre and weight hundreds of powers of ten apart.
RATIOS = {
    "a moment near zero": ('1, 1, "1e-300"', "0.1, 0, 1", "1"),
    "another one": ('1, "1e-300", 1', "0.1, 0, 1", "1"),
    "a heavy one": ('"1e300", "1e300", "1e-300"', "0.1, 0.2, 1", "1e300"),
    "small ones": ('"1e-300", "1e-300", "1e-300"', "0, 0, 1", "1"),
    "beyond doubles": ('"1e400", "1e400", "1e400"', '0.1, 0.2, "1e300"', "1e300"),
}
RATIO = """schema = 1
[body]
moments = [{}]
centre = [{}]
weight = "{}"
[start]
omega = [0.1, 0.2, 3]
gamma = ["3/5", 0, "4/5"]
[run]
end = 10
samples = 5
"""


# -- valid scenes that are extreme -----------------------------------------------------------------

KINDS = ("euler", "lagrange", "kovalevskaya", "pendulum", "general")
GAMMAS = [
    (Fraction(3, 5), 0, Fraction(4, 5)),
    (Fraction(2, 7), Fraction(3, 7), Fraction(6, 7)),
    (0, Fraction(-5, 13), Fraction(12, 13)),
]


def powers(most: int) -> st.SearchStrategy[Fraction]:
    """Numbers of any size between 10**-most and 10**most."""
    return st.builds(
        lambda x, n: Fraction(x, 10) * Fraction(10) ** n,
        st.integers(1, 99),
        st.integers(-most, most),
    )


@st.composite
def extreme(draw: st.DrawFn, kind: str) -> polhode.Scene:
    """A scene of a kind of top that turns by about a radian."""
    size, hair = draw(powers(100)), Fraction(1, 10 ** draw(of((1, 8, 30))))
    weight, gamma = draw(powers(200)), draw(of(GAMMAS))
    omega = [draw(powers(3)) * draw(of((-1, 1))) for _ in range(3)]
    moments, centre = [Fraction(2), Fraction(3), 3 + hair], (1, 2, 3)
    if kind == "euler":
        moments, centre = draw(st.permutations([Fraction(1), 1 + hair / 3, hair])), (0, 0, 0)
        omega = draw(of((omega, [hair, 1, hair], [1, hair, 0])))
    elif kind == "lagrange":
        moments, centre = [Fraction(1), Fraction(1), draw(powers(6)) % 2 or 1], (0, 0, 1)
        omega = draw(of((omega, [hair, 0, 10 ** draw(st.integers(0, 8))])))
    elif kind == "kovalevskaya":
        moments, centre = [Fraction(2), Fraction(2), Fraction(1)], (1, 0, 0)
    elif kind == "pendulum":
        moments, centre = [Fraction(2), Fraction(3), Fraction(4)], (1, 0, 0)
        omega, gamma = [0, 0, omega[2]], (0, 1, 0)
    # the unit of time in which a weight of that size turns the body by about a radian
    torque = weight * (centre != (0, 0, 0))
    rate = _root(torque / (size * max(moments))) if torque else draw(powers(100))
    fastest = max(abs(w) for w in omega)
    omega = [Fraction(w) / fastest * rate * draw(of((1, 2))) for w in omega]
    heavy = polhode.Body.of_moments([size * m for m in moments], centre, torque)
    time = draw(of((1, -1))) / max(abs(w) for w in omega)
    return polhode.Scene(heavy, omega, gamma, times=(time,), name=kind)


def _root(x: Fraction) -> Fraction:
    """A power of ten near the root of a number: a rate of its size."""
    digits = len(str(x.numerator)) - len(str(x.denominator))
    return Fraction(10) ** (digits // 2)
