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

    def job(self, present: Sequence[bool], runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """The job of :mod:`peers.process`."""
        shared = {"module": self.module, "method": self.method}
        return {**shared, "present": [*present], "runs": [*runs]}

    def prepared(self, present: Sequence[bool], many: bool = False) -> Run:
        """Its prepared form for a pattern of the equations, of one start or of many."""
        module = import_module(self.module)
        run: Run = (module.prepared_many if many else module.prepared)(present, self.method)
        return run


def _peer(
    name: str, module: str, method: str, line: str, needs: Sequence[str], **limits: Any
) -> Program:
    return Program(name, f"peers.{module}", method, line, needs=tuple(needs), **limits)


_NUMBA = ("numba",)
_OWN = "peers.own"
_SHORT: dict[str, Any] = {"last": 1000, "outputs": 101}
PROGRAMS = (
    Program(OURS, _OWN, "propagator", "polhode, double", (*_TAYLOR, PROJECTED)),
    Program(RUN, _OWN, "integrate", "", _TAYLOR),
    Program(WIDER, _OWN, "extended", "polhode, extended", _WIDER_LADDER, *DIAGRAM),
    _peer(ENGINE, "bare_heyoka", "", "heyoka by hand", ("heyoka",), tolerances=_TAYLOR),
    _peer("CyRK DOP853", "cyrk", "DOP853", "CyRK", (*_NUMBA, "CyRK")),
    _peer("CyRK VERN8", "cyrk", "VERN8", "CyRK", (*_NUMBA, "CyRK")),
    _peer(
        *("numbalsoda dop853", "numbalsoda_cfunc", "dop853", "numbalsoda"),
        (*_NUMBA, "numbalsoda"),
    ),
    _peer(
        *("numbalsoda lsoda", "numbalsoda_cfunc", "lsoda", "numbalsoda"),
        (*_NUMBA, "numbalsoda"),
        last=1000,
    ),
    _peer("SciPy DOP853", "scipy_ode", "DOP853", "SciPy, numba", ("scipy", *_NUMBA), **_SHORT),
    _peer("SciPy LSODA", "scipy_ode", "LSODA", "SciPy, numba", ("scipy", *_NUMBA), last=1000),
    _peer(
        *("diffrax Dopri8", "diffrax_dopri8", "Dopri8", "diffrax", ("diffrax",)),
        last=100,
        outputs=101,
    ),
    _peer("splitting 8", "splitting", "8", "splitting", _NUMBA, tolerances=_FIXED, **_SHORT),
    _peer(
        *("splitting 8 compensated", "splitting", "8 compensated", "splitting", _NUMBA),
        tolerances=_FIXED,
        **_SHORT,
    ),
    #: Of the table of first results alone: nothing to compile, and slow ever after.
    _peer("SciPy DOP853, Python", "scipy_ode", "DOP853, Python", "", ("scipy",), last=0),
    _peer("CyRK DOP853, Python", "cyrk", "DOP853, Python", "", ("CyRK",), last=0),
)
#: Those that are called with many starts: all that have a way of their own for them.
MANY = (
    *(OURS, RUN, ENGINE),
    *("CyRK DOP853", "CyRK VERN8", "numbalsoda dop853", "numbalsoda lsoda", "diffrax Dopri8"),
)
BY_NAME: Mapping[str, Program] = {program.name: program for program in PROGRAMS}
