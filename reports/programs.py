"""The programs of the contest, each as its own documentation would have it called from Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple

from peers.field import Run
from tops import DIAGRAM

OURS, ENGINE, RUN = "polhode propagator", "heyoka by hand", "polhode integrate"
WIDER = "polhode extended"
#: Not among "the others", with which polhode's propagator is compared.
OWN = (OURS, RUN, WIDER, ENGINE)

EPS = 2.0**-52
PROJECTED = 0.0  # the tolerance eps, the state put back on its integrals
_LADDER = tuple(10.0**-k for k in (3, 5, 7, 9, 11, 13))
_TAYLOR = (*_LADDER, EPS)
_WIDER_LADDER = (1e-11, 1e-13, 1e-15, 1e-17, 2.0**-63)
_FIXED = (1.0, 1e-2, 1e-4, 1e-6, 1e-8)  # tol^(1/8) is the step of the splittings


class Program(NamedTuple):
    """A name, the module that prepares it, the module's word for the method, its tolerances.

    ``line``: that of the diagram in which it is drawn, none for "".  ``last``, ``outputs``: how far
    it is run, in cells of how many outputs at most: slow programs take minutes for what others do
    in milliseconds.  ``needs``: the packages it is made of.
    """

    name: str
    module: str
    method: str
    line: str
    tolerances: tuple[float, ...] = _LADDER
    last: int = 10_000
    outputs: int = 10_001
    needs: tuple[str, ...] = ()

    def runs(self, end: int, outputs: int, starts: int = 0) -> bool:
        """Whether it is run in cells of this length and number of outputs, or of starts."""
        return end <= self.last and outputs <= self.outputs and (not starts or self.name in MANY)

    @property
    def is_there(self) -> bool:
        """Whether all that it needs is installed."""
        return all(find_spec(need) is not None for need in self.needs)

    def job(self, present: Sequence[bool], runs: Sequence[tuple[Any, ...]]) -> dict[str, Any]:
        """The job of :mod:`peers.process`."""
        return {"module": self.module, "method": self.method, "present": present, "runs": runs}

    def prepared(self, present: Sequence[bool], many: bool = False) -> Run:
        """Its prepared form for a pattern of the equations, of one start or of many."""
        run: Run = import_module(self.module).prepared(present, self.method, *[True] * many)
        return run


#: Of the other packages the module here, the line of the diagram, and what has to be installed.
_PACKAGES = {
    "CyRK": ("cyrk", "CyRK", ("numba", "CyRK")),
    "numbalsoda": ("numbalsoda_cfunc", "numbalsoda", ("numba", "numbalsoda")),
    "SciPy": ("scipy_ode", "SciPy, numba", ("scipy", "numba")),
    "diffrax": ("diffrax_dopri8", "diffrax", ("diffrax",)),
    "splitting": ("splitting", "splitting", ("numba",)),
}


def _peer(name: str, **limits: Any) -> Program:
    """A program called by its package and method."""
    package, _, method = name.partition(" ")
    module, line, needs = _PACKAGES[package]
    if method.endswith(", Python"):  # nothing to compile, and slow: of first results alone
        line, needs, limits = "", tuple(x for x in needs if x != "numba"), {"last": 0}
    return Program(name, f"peers.{module}", method, line, needs=needs, **limits)


_OWN = "peers.own"
_SHORT: dict[str, Any] = {"last": 1000, "outputs": 101}
PROGRAMS = (
    Program(OURS, _OWN, "propagator", "polhode, double", (*_TAYLOR, PROJECTED)),
    Program(RUN, _OWN, "integrate", "", _TAYLOR),
    Program(WIDER, _OWN, "extended", "polhode, extended", _WIDER_LADDER, *DIAGRAM),
    Program(ENGINE, "peers.bare_heyoka", "", ENGINE, _TAYLOR, needs=("heyoka",)),
    _peer("CyRK DOP853"),
    _peer("CyRK VERN8"),
    _peer("numbalsoda dop853"),
    _peer("numbalsoda lsoda", last=1000),
    _peer("SciPy DOP853", **_SHORT),
    _peer("SciPy LSODA", last=1000),
    _peer("diffrax Dopri8", last=100, outputs=101),
    _peer("splitting 8", tolerances=_FIXED, **_SHORT),
    _peer("splitting 8 compensated", tolerances=_FIXED, **_SHORT),
    _peer("SciPy DOP853, Python"),
    _peer("CyRK DOP853, Python"),
)
#: Those that are called with many starts: all that have a way of their own for them.
MANY = (
    *(OURS, RUN, ENGINE),
    *("CyRK DOP853", "CyRK VERN8", "numbalsoda dop853", "numbalsoda lsoda", "diffrax Dopri8"),
)
BY_NAME: Mapping[str, Program] = {program.name: program for program in PROGRAMS}
