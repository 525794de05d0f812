"""Who takes part in the study ``speed``: the motions, and the methods that run each of them."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.number_types import DOUBLE, named
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene
from polhode.studies.peer_processes import Method, plain_scene

SAMPLES = 11
TYPES_SHOWN = "Kovalevskaya top"  # the motion on which all number types are drawn
PLAIN = "polhode double"
PROJECTED = "polhode double projected"
ENGINE = "heyoka alone"


class SpeedMotion(NamedTuple):
    """A case of the library to its own end; ``kind``: regular, chaotic, or short for slow peers."""

    name: str
    case: str
    end: int
    kind: str


MOTIONS = (
    SpeedMotion("Euler top", "euler/largest-axis", 1000, "regular"),
    SpeedMotion("Lagrange top", "lagrange/nutation", 1000, "regular"),
    SpeedMotion("Kovalevskaya top", "kovalevskaya/generic", 1000, "regular"),
    SpeedMotion("asymmetric body", "general/asymmetric-regular", 1000, "regular"),
    SpeedMotion("asymmetric body, chaotic", "general/asymmetric-chaotic", 100, "chaotic"),
    SpeedMotion("asymmetric body, short", "general/asymmetric-regular", 2, "short"),
)

_OWN = "polhode.studies.isolated_process"
_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
_FINE = {
    "double": (*_TOLERANCES, 2.0**-52),
    "extended": (1e-12, 1e-15, 2.0**-63),
    "quad": (1e-20, 2.0**-112),
    "mp": (float(named("mp").eps),),
}


#: Of the slow peers, whose runs to t = 1000 take seconds; and the motions on which they run.
_FEW = (1e-8, 1e-12, 1e-14)
SLOW = ("SciPy DOP853, Python", "SciPy LSODA, Python", "diffrax Dopri8")
_SLOW_ON = ("Euler top", "Kovalevskaya top")


def _peer(
    name: str, module: str, method: str = "", tolerances: tuple[float, ...] = _TOLERANCES
) -> Method:
    return Method(name, f"polhode.peers.{module}", method, tolerances)


#: Wide types are projected at their own tolerance alone: they are not unless they are asked to be.
_PROJECTED = _FINE | {"quad": _FINE["quad"][-1:]}
OURS = tuple(
    Method(f"polhode {word}", _OWN, word, tolerances[number], number, 120.0)
    for number in _FINE
    for word, tolerances in ((number, _FINE), (f"{number} projected", _PROJECTED))
)
HEYOKA = Method(ENGINE, "polhode.peers.bare_heyoka", "", _FINE["double"])
SPLITTINGS = tuple(
    Method(f"splitting {word}", "polhode.peers.splitting", word, tolerances)
    for word, tolerances in (
        ("4", (1e-4, 1e-6, 1e-8)),
        ("8", (1e-4, 1e-6, 1e-8, 1e-10)),
        ("8 compensated", (1e-4, 1e-6, 1e-8, 1e-10)),
    )
)
PEERS = (
    _peer("SciPy DOP853, Python", "scipy_python", "DOP853", _FEW),
    _peer("SciPy LSODA, Python", "scipy_python", "LSODA", _FEW),
    _peer("numbalsoda dop853", "numbalsoda_cfunc", "dop853"),
    _peer("numbalsoda lsoda", "numbalsoda_cfunc", "lsoda"),
    _peer("CyRK DOP853", "cyrk", "DOP853"),
    _peer("CyRK VERN8", "cyrk", "VERN8"),
    _peer("CyRK LSODA", "cyrk", "LSODA"),
    _peer("diffrax Dopri8", "diffrax_dopri8", "Dopri8", _FEW),
    *SPLITTINGS,
)
#: Of the short motion alone.  SciPy's steps are taken in Python, so that compiling the right-hand
#: side gains it next to nothing: both stand here, side by side.
SHORT_PEERS = (
    _peer("mpmath odefun", "mpmath_odefun"),
    PEERS[0]._replace(tolerances=_TOLERANCES),
    _peer("SciPy DOP853, numba", "scipy_numba", "DOP853"),
)

QUICK_MOTIONS = ("Kovalevskaya top", "asymmetric body, short")
QUICK_TYPES = ("double", "extended")
QUICK_PEERS = ("scipy_python", "mpmath_odefun")  # what needs no compiler
QUICK_TOLERANCES = (1e-8, 1e-12, 2.0**-52, 2.0**-63, 1e-14)


def methods(motion: SpeedMotion, quick: bool) -> list[Method]:
    """The methods that run a motion: some peers on the short one alone, the others on the rest."""
    chosen = [*OURS, HEYOKA, *(SHORT_PEERS if motion.kind == "short" else PEERS)]
    if not quick:
        return chosen
    return [
        method._replace(tolerances=tuple(t for t in method.tolerances if t in QUICK_TOLERANCES))
        for method in chosen
        if (method in OURS and method.number in QUICK_TYPES)
        or method is HEYOKA
        or method.module.rpartition(".")[2] in QUICK_PEERS
    ]


def reported(motion: SpeedMotion, method: Method) -> bool:
    """Whether a method is run on a motion without being asked for it by name.

    Steps in quad and mp that are projected take 3 to 15 seconds to t = 1000, and nothing is
    projected in these types unless it is asked to be: one motion shows them.  The slowest programs
    take seconds, too, tens of times polhode's and more: two motions show them.
    """
    if motion.end < 1000:
        return True
    wide = method in OURS and method.number in ("quad", "mp") and method.name.endswith("projected")
    if wide:
        return motion.name == TYPES_SHOWN
    return method.name not in SLOW or motion.name in _SLOW_ON


def scene_of(motion: SpeedMotion) -> Scene:
    """The motion's scene at its output times, which every method takes as doubles."""
    times = [DOUBLE.rounded(t) for t in even_times(Fraction(motion.end), SAMPLES)]
    return plain_scene(motion.case, times)
