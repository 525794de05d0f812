"""The closed form that fits a scene, asked in the scene's own axes.

A closed form shares no code with the integrator: it reads the exact scene and nothing else.
FAMILIES lists polhode's own; :func:`register_family` adds one from outside.  A new one of polhode's
is a file or a folder beside this file, its row in FAMILIES, and one word in
:data:`polhode.scenes.vocabulary.REFERENCES`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from importlib import import_module
from typing import Any

from polhode.closed_forms import euler, pendulum
from polhode.closed_forms._one_orbit import (
    bobylev_steklov,
    chaplygin,
    goryachev,
    grioli,
    n_kowalewski,
    staude,
    steklov,
)
from polhode.closed_forms._one_orbit.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._one_orbit.orbits import orbit_family
from polhode.closed_forms.balls.frames import Motion, Rows
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.family import Family, Placement
from polhode.closed_forms.goryachev_chaplygin import place as goryachev_chaplygin
from polhode.closed_forms.hess import place as hess
from polhode.closed_forms.kovalevskaya import place as kovalevskaya
from polhode.closed_forms.lagrange import place as lagrange
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    NormalScene,
    PrincipalScene,
    equal,
    in_principal_axes,
    positive,
)
from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_mpf as number
from polhode.numbers.exact import Exact, noted
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.vectors import Vector
from polhode.scenes import vocabulary
from polhode.scenes.scene import Scene

__all__ = [
    "FAMILIES",
    "ClosedForm",
    "Condition",
    "Family",
    "Misfit",
    "NormalScene",
    "Orbit",
    "OrbitMotion",
    "PrincipalScene",
    "closed_form",
    "closed_forms",
    "equal",
    "misfit",
    "mpmath",
    "near",
    "number",
    "orbit_family",
    "positive",
    "register_family",
]

_NEAR = Fraction(1, 1000)


def _solved_in(folder: str, solver: str) -> Callable[[Any], Motion]:
    """The solver of a family's ``motion``, whose formulas are imported when one is solved."""

    def solve(place: Placement) -> Motion:
        motion: Motion = getattr(import_module(f"polhode.closed_forms.{folder}.motion"), solver)(
            place
        )
        return motion

    return solve


#: In the order in which a scene is tried; the first that fits is its reference.  Kovalevskaya's top
#: is the last of those that may fit its body: it has no formula for a pendulum's motions, permanent
#: rotations and Bobylev and Steklov's.  Families after it need not be asked about that body.
FAMILIES: tuple[Family, ...] = (
    euler.FAMILY,
    Family("lagrange", lagrange.place, lagrange.misfit, _solved_in("lagrange", "solve")),
    pendulum.FAMILY,
    orbit_family("staude", staude.Staude),
    orbit_family("bobylev-steklov", bobylev_steklov.BobylevSteklov),
    Family(
        "kovalevskaya",
        kovalevskaya.place,
        kovalevskaya.misfit,
        _solved_in("kovalevskaya", "solve"),
    ),
    orbit_family("grioli", grioli.Grioli),
    Family(
        "goryachev-chaplygin",
        goryachev_chaplygin.place,
        goryachev_chaplygin.misfit,
        _solved_in("goryachev_chaplygin", "GoryachevMotion"),
    ),
    Family("hess", hess.place, hess.misfit, _solved_in("hess", "HessMotion")),
    orbit_family("steklov", steklov.Steklov),
    orbit_family("goryachev", goryachev.Goryachev),
    orbit_family("n-kowalewski", n_kowalewski.NKowalewski),
    orbit_family("chaplygin", chaplygin.Chaplygin),
)


def register_family(family: Family) -> None:
    """Add your own family of closed forms to this process.

    It is tried after polhode's own families, and can be chosen by its name in ``reference.kind``.
    A package whose entry points have it in the group ``polhode.families`` provides it to every
    process, including the command line.

    Parameters
    ----------
    family : Family
        Its name, how it places a scene, and what solves the motion; :func:`orbit_family`
        makes one of a class of periodic motions.

    Raises
    ------
    BadInput
        Something that is no family, or a name that another family has.

    Notes
    -----
    ``polhode guide closed-forms`` shows an example.  A closed form is a reference: runs are judged
    by it, and only its author's tests check it.

    Examples
    --------
    >>> import polhode
    >>> from polhode.closed_forms.families import FAMILIES
    >>> polhode.register_family(FAMILIES[0])
    Traceback (most recent call last):
    ...
    polhode.common.errors.BadInput: register_family: name = euler: expected one that no family has
    """
    of_kind("register_family", "family", family, Family, "a Family")
    vocabulary.add(family.name, family)


def known_families() -> Iterator[Family]:
    """polhode's own, then those from outside; raises BadInput for what is none."""
    yield from FAMILIES
    for family in vocabulary.added():
        if not isinstance(family, Family):
            raise BadInput(vocabulary.GROUP, "family", repr(family), "a Family")
        yield family


def closed_form(scene: Scene, kind: str = "auto") -> tuple[str, ClosedForm] | None:
    """The name and the closed form of the first family that fits body and start, if any does.

    ``kind`` asks for one family by name.
    """
    return next(closed_forms(scene, kind), None)


def closed_forms(scene: Scene, kind: str = "auto") -> Iterator[tuple[str, ClosedForm]]:
    """Name and closed form of every family that fits body and start, in their order."""
    principal = in_principal_axes(scene)
    start = scene.omega, scene.gamma, scene.psi
    axes = None if scene.body.axes.trivial else scene.body.axes.rows
    for family in known_families():
        if kind in ("auto", family.name):
            form = form_of(family, principal, start, axes)
            if form is not None:
                yield family.name, form


def form_of(
    family: Family,
    principal: PrincipalScene,
    start: tuple[Vector, Vector | None, Exact],
    axes: Rows | None = None,
) -> ClosedForm | None:
    """The closed form of a scene that belongs to the family; None of one that does not.

    ``start``: omega, gamma and psi at t = 0 in the scene's axes; ``axes``: the principal ones in
    them, None where they are the same.
    """
    with noted() as called_zero:
        place = family.place(principal)
    if place is None:
        return None
    return ClosedForm(place, family.solve, start, axes, called_zero)


def misfit(scene: Scene, kind: str) -> Misfit | None:
    """Why a scene does not belong to the family of that name, where that family can say it."""
    for family in known_families():
        if family.name == kind:
            return family.misfit(in_principal_axes(scene))
    return None


def near(scene: Scene, within: Fraction = _NEAR) -> list[tuple[str, Misfit]]:
    """The families that a scene is near to, each with its Misfit.

    Near: all conditions hold up to ``within``, but not all of them exactly.
    """
    principal = in_principal_axes(scene)
    misfits = ((family.name, family.misfit(principal)) for family in known_families())
    return [(name, miss) for name, miss in misfits if miss is not None and miss.within(within)]
