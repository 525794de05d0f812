"""A family of closed forms: what it asks of a scene, and what makes the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from polhode.closed_forms.closed_form import ClosedForm, Rows
from polhode.closed_forms.membership.misfit import Misfit
from polhode.closed_forms.membership.principal_scene import PrincipalScene
from polhode.numbers.exact import Exact
from polhode.numbers.vectors import Vector


class Maker(Protocol):
    """Makes the closed form of one scene, as :class:`ClosedForm` is made; ValueError: no fit."""

    def __call__(
        self,
        *,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector | None,
        psi: Exact,
        axes: Rows | None,
    ) -> ClosedForm:
        """The closed form of that body and start."""
        ...


@dataclass(frozen=True)
class Family:
    """One family of closed forms.

    ``name``: the word of ``reference.kind`` in a scene file.  ``fits``: whether a scene belongs, by
    exact arithmetic alone.  ``misfit``: why one does not; None of one that belongs.
    ``closed_form``: gives the maker, and imports what it needs when it is called.
    """

    name: str
    fits: Callable[[PrincipalScene], bool]
    misfit: Callable[[PrincipalScene], Misfit | None]
    closed_form: Callable[[], Maker]
