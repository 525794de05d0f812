"""Forms of the equations of motion: one file per form, each field written once for any scalar.

A form works in axes of its own and in its own variables: it is made of the scene inside its frame
(:mod:`polhode.motion.frame`), whose axes are the principal ones but for forms whose file has a
function ``axes``.  Its ``field`` and its way back to omega and gamma take the variables, the exact
non-zero coefficients by name as the run's numbers, and the scalar's own functions: the same lines
feed floats, mpmath numbers and heyoka expressions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, ClassVar, TypeAlias

from polhode.common.values import Recent
from polhode.motion.frame import NO_CHANGE, Frame
from polhode.numbers.scalars import Functions, Scalar

if TYPE_CHECKING:
    from polhode.numbers.exact import Exact
    from polhode.scenes.scene import Scene

#: The variables at one moment, or columns of them; the coefficients by name; omega and gamma.
Values: TypeAlias = Sequence[Scalar]
Coefficients: TypeAlias = Mapping[str, Scalar]
OmegaAndGamma: TypeAlias = tuple[list[Scalar], list[Scalar]]


@dataclass(frozen=True)
class Form(ABC):
    """The equations of one scene in one form.

    ``scene``: the one inside ``frame``, from which the frame leads to the scene asked for.
    ``variables``: names of what is integrated.
    ``coefficients``: exact numbers by name, none of them zero.  ``start``: the variables at t = 0,
    exactly.  ``unit``: which variables form a vector of length one, held so by projection.
    ``instead``: the form to take where this one meets its singular set.  ``plain``: the variables
    are omega and gamma themselves.
    """

    scene: Scene
    variables: tuple[str, ...]
    coefficients: Mapping[str, Exact]
    start: tuple[Exact, ...]
    _: KW_ONLY
    frame: Frame = NO_CHANGE

    unit: ClassVar[slice | None] = None
    instead: ClassVar[str] = "principal"
    plain: ClassVar[bool] = False

    @abstractmethod
    def field(self, values: Values, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The variables' rates."""

    @abstractmethod
    def state(self, values: Values, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega and gamma inside the frame; gamma [] for a scene without it."""

    def distance(self, values: Values, k: Coefficients, fn: Functions) -> Scalar:
        """How near the singular set is, squared: 0 on it, of order 1 away from it; None without."""
        return None


def equations(scene: Scene) -> Form:
    """The equations of a scene in the form that it asks for; raises BadInput where it has none."""
    return _kept.get(scene.identity, scene.form, lambda: _made(scene))


_kept: Recent[Form] = Recent(2)  # a run asks several times


def _made(scene: Scene) -> Form:
    module = _module(scene.form)
    axes = module.axes(scene) if hasattr(module, "axes") else None
    frame = Frame.of(scene, axes)
    form: Form = module.for_scene(frame.inside(scene.apart()))
    vars(form)["frame"] = frame  # nobody else has it yet
    return form


def source(name: str) -> str:
    """Where a form stands in the source: equation numbers."""
    return str(_module(name).SOURCE)


def _module(name: str) -> ModuleType:
    """A form's module, imported when it is asked for."""
    return import_module(f"polhode.equations.forms.{name.replace('-', '_')}")
