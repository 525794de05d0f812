"""A family of closed forms: what it asks of a scene, and what makes the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.membership import Conditions, Misfit, PrincipalScene, placed_in, shortfall

#: Makes the closed form of one scene; ValueError: no fit.
Maker: TypeAlias = type[ClosedForm[Any]]


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


def by_conditions(
    name: str,
    conditions: Conditions,
    closed_form: Callable[[], Maker],
    fits: Callable[[PrincipalScene], bool] | None = None,
) -> Family:
    """A family that its conditions in the axes of its normal form decide, or ``fits``."""

    def belongs(scene: PrincipalScene) -> bool:
        return placed_in(conditions, scene) is not None

    def misfit(scene: PrincipalScene) -> Misfit | None:
        return None if fits is not None and fits(scene) else shortfall(conditions, scene)

    return Family(name, fits or belongs, misfit, closed_form)
