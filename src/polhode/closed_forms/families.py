"""The closed form that fits a scene, asked in the scene's own axes.

A closed form shares no code with the integrator: it reads the exact scene and nothing else.
FAMILIES lists all that there are.  A new family is a folder beside this file, one row of the table,
and one word in :data:`polhode.scenes.vocabulary.REFERENCES`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple, Protocol

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.principal_scene import PrincipalScene, in_principal_axes
from polhode.numbers.exact import Exact
from polhode.numbers.scalars import Real
from polhode.scenes.body import Vector
from polhode.scenes.scene import Scene

_NEAR = Fraction(1, 1000)

Rows = tuple[tuple[Exact, ...], ...]


class ClosedForm(Protocol):
    """What every closed form answers, in the scene's body axes and units, to any number of digits.

    ``times`` are exact, of either sign and in any order; answers are mpf.  A question that the
    closed form cannot answer (a time beyond what its turns can be counted to, digits lost to an
    asymptotic motion) raises ValueError, numbers that contradict each other ArithmeticError.
    """

    @property
    def regime(self) -> str:
        """The kind of motion, decided once by exact arithmetic."""
        ...

    def at(self, times: Sequence[Exact], digits: int) -> list[list[Real]]:
        """Rows p q r [gamma1 gamma2 gamma3], one a time.

        The error is below 10^-digits: of w relative to its largest modulus, of gamma absolute.
        """
        ...

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[Real]]:
        """Rows q0 q1 q2 q3: the unit quaternion body -> space (z up), scalar first.

        q0 >= 0 at t = 0 (the first component that is not 0 is positive), then continuous in time.
        """
        ...

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[Real | None]]:
        """Rows psi theta phi in radians, continuous in time; psi and phi None at a pole."""
        ...

    def period(self, digits: int) -> Real | None:
        """The period of w in the body, in the scene's unit of time; None where there is none."""
        ...

    def frequencies(self, digits: int) -> dict[str, Real]:
        """The motion's frequencies, radians per unit of time, by name."""
        ...


class Maker(Protocol):
    """The class of a family: makes the closed form of one scene; raises ValueError unless it fits.

    ``moments`` and ``torque`` (Mg r0) in principal axes; ``omega``, ``gamma`` and ``psi`` at t = 0
    in the scene's body axes; ``axes[i]`` is the unit vector of principal axis i in the scene's
    axes, right-handed, None for the same axes.
    """

    def __call__(
        self,
        *,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector | None,  # None for a torque-free body of which only omega is asked
        psi: Exact,
        axes: Rows | None,
    ) -> ClosedForm:
        """The closed form of that body and start."""
        ...


class Family(NamedTuple):
    """One row of FAMILIES.  Code is named as ``module:name`` below this package, and imported only
    when it is asked.

    ``name``: the word of ``reference.kind`` in a scene file.  ``fits``: whether a PrincipalScene
    belongs, by exact arithmetic alone.  ``closed_form``: the class, a Maker.  ``misfit``: the
    Misfit of a PrincipalScene, None of one that belongs.  ``special``: of one that belongs, the
    names of the family's special motions, each with the Misfit, None where there is none to tell;
    empty for a family without any.
    """

    name: str
    fits: str
    closed_form: str
    misfit: str
    special: str = ""


#: In the order in which a scene is tried; the first that fits is its reference.
FAMILIES = (
    Family(
        "euler",
        "euler.conditions:fits",
        "euler.top:EulerTop",
        "euler.conditions:misfit",
        "euler.special:special",
    ),
    Family(
        "lagrange",
        "lagrange.axes:fits",
        "lagrange.top:LagrangeTop",
        "lagrange.conditions:misfit",
        "lagrange.special:special",
    ),
    Family(
        "kovalevskaya",
        "kovalevskaya.axes:fits",
        "kovalevskaya.top:KovalevskayaTop",
        "kovalevskaya.conditions:misfit",
        "kovalevskaya.special:special",
    ),
    Family(
        "pendulum",
        "pendulum.conditions:fits",
        "pendulum.top:Pendulum",
        "pendulum.conditions:misfit",
        "pendulum.special:special",
    ),
    Family(
        "staude",
        "staude.conditions:fits",
        "staude.top:Staude",
        "staude.conditions:misfit",
    ),
    Family(
        "bobylev-steklov",
        "bobylev_steklov.conditions:fits",
        "bobylev_steklov.top:BobylevSteklov",
        "bobylev_steklov.conditions:misfit",
        "bobylev_steklov.special:special",
    ),
    Family(
        "grioli",
        "grioli.conditions:fits",
        "grioli.top:Grioli",
        "grioli.conditions:misfit",
    ),
    Family(
        "goryachev-chaplygin",
        "goryachev_chaplygin.conditions:fits",
        "goryachev_chaplygin.top:GoryachevChaplyginTop",
        "goryachev_chaplygin.conditions:misfit",
        "goryachev_chaplygin.special:special",
    ),
    Family(
        "hess",
        "hess.conditions:fits",
        "hess.top:HessTop",
        "hess.conditions:misfit",
        "hess.special:special",
    ),
    Family(
        "steklov",
        "steklov.conditions:fits",
        "steklov.top:Steklov",
        "steklov.conditions:misfit",
    ),
    Family(
        "goryachev",
        "goryachev.conditions:fits",
        "goryachev.top:Goryachev",
        "goryachev.conditions:misfit",
    ),
    Family(
        "n-kowalewski",
        "n_kowalewski.conditions:fits",
        "n_kowalewski.top:NKowalewski",
        "n_kowalewski.conditions:misfit",
    ),
    Family(
        "chaplygin",
        "chaplygin.conditions:fits",
        "chaplygin.top:Chaplygin",
        "chaplygin.conditions:misfit",
    ),
)


def closed_form(scene: Scene, kind: str = "auto") -> tuple[str, ClosedForm] | None:
    """The name and the closed form of the first family that fits body and start, if any does.

    ``kind`` asks for one family by name.
    """
    return next(closed_forms(scene, kind), None)


def closed_forms(scene: Scene, kind: str = "auto") -> Iterator[tuple[str, ClosedForm]]:
    """Name and closed form of every family that fits body and start, in the order of FAMILIES."""
    principal = in_principal_axes(scene)
    for family in FAMILIES:
        if kind in ("auto", family.name) and _code(family.fits)(principal):
            yield family.name, _made(family, scene, principal)


def misfit(scene: Scene, kind: str) -> Misfit | None:
    """Why a scene does not belong to the family of that name, where that family can say it."""
    for family in FAMILIES:
        if family.name == kind:
            found: Misfit | None = _code(family.misfit)(in_principal_axes(scene))
            return found
    return None


def near(scene: Scene, within: Fraction = _NEAR) -> list[tuple[str, Misfit]]:
    """The families, and special motions of its own, that a scene is near to, each with its Misfit.

    Near: all conditions hold up to ``within``, but not all of them exactly.  A special motion is
    named "family, motion"; its family is the first that fits.
    """
    found, special = [], None
    principal = in_principal_axes(scene)
    for family in FAMILIES:
        missed: Misfit | None = _code(family.misfit)(principal)
        if missed is None and special is None:
            special = family
        elif missed is not None and missed.within(within):
            found.append((family.name, missed))
    if special is not None and special.special:
        motions = _code(special.special)(principal)
        found = [
            *(
                (f"{special.name}, {name}", miss)
                for name, miss in motions
                if miss is not None and miss.within(within)
            ),
            *found,
        ]
    return found


def _made(family: Family, scene: Scene, principal: PrincipalScene) -> ClosedForm:
    maker: Maker = _code(family.closed_form)
    return maker(
        moments=principal.moments,
        torque=principal.torque,
        omega=scene.omega,
        gamma=scene.gamma,
        psi=scene.psi,
        axes=None if scene.body.axes.trivial else scene.body.axes.rows,
    )


@cache
def _code(path: str) -> Any:
    """What a row of FAMILIES names, imported when it is first asked."""
    module, name = path.split(":")
    return getattr(import_module(f"polhode.closed_forms.{module}"), name)
