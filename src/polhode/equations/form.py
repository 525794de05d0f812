"""Forms of the equations of motion: one file per form, each field written once for any scalar.

A form works in axes of its own and in its own variables: it is made of the scene inside its frame
(:mod:`polhode.motion.frame`), whose axes are the principal ones but for forms whose file has a
function ``axes``.  Its ``field`` and its way back to omega and gamma take the variables, the exact
non-zero coefficients by name as the run's numbers, and the scalar's own functions: the same lines
feed floats, mpmath numbers and heyoka expressions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.values import Recent
from polhode.motion.frame import NO_CHANGE, Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Doubles, Functions, Scalar
from polhode.numbers.vectors import cross, inverse
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

#: The variables at one moment, or columns of them; the coefficients by name; omega and gamma.
FormValues: TypeAlias = Sequence[Scalar]
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
    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The variables' rates."""

    @abstractmethod
    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega and gamma inside the frame; gamma [] for a scene without it."""

    def distance(self, values: FormValues, k: Coefficients, fn: Functions) -> Scalar:
        """How near the singular set is, squared: 0 on it, of order 1 away from it; None without."""
        return None


def equations(scene: Scene) -> Form:
    """The equations of a scene in the form that it asks for; raises BadInput where it has none."""
    return _recent.get(scene.identity, scene.form, lambda: _new_form(scene))


_recent: Recent[Form] = Recent(2)  # a run asks several times


def _new_form(scene: Scene) -> Form:
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


# --- plain field ----------------------------------------------------------------------------------
#
# The equations as a function of doubles, for somebody else's integrator (3.16–3.17).


def field(scene: Scene | str | Path) -> Callable[[float, npt.ArrayLike], Doubles]:
    """Give the rates of p q r [gamma1 gamma2 gamma3] as a function f(t, y) of doubles.

    It is the right-hand side for ``scipy.integrate.solve_ivp`` and similar programs.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.

    Returns
    -------
    callable
        f(t, y) -> ndarray of the shape of ``y``: (6,), or (6, n) for n states at once; three rows
        where a torque-free scene has no gamma.  ``f.start`` is the state at t = 0.

    Raises
    ------
    BadInput
        A scene that cannot be read.

    Notes
    -----
    In the scene's own axes and units ::

        w' = I⁻¹ (Mg gamma × r0 - w × I w),    gamma' = gamma × w

    with w = (p, q, r), (3.16-3.17) of Yehia, *Rigid Body Dynamics: A Lagrangian Approach*.

    Examples
    --------
    >>> import polhode
    >>> f = polhode.field("lagrange/nutation")
    >>> f.start.tolist()
    [0.16, 0.3, 4.1, 0.8, 0.0, 0.6]
    >>> f(0, f.start).round(12).tolist()
    [0.615, -1.128, 0.0, -0.18, -3.184, 0.24]
    """
    return _PlainField(library.load(scene, takes=REQUESTS))


class _PlainField:
    def __init__(self, scene: Scene) -> None:
        self._name = scene.name
        body = scene.body
        self.inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
        self.inverse = np.array([[to_double(x) for x in row] for row in inverse(body.inertia)])
        self.torque = np.array([to_double(x) for x in body.torque])
        self.start: Any = np.array([to_double(x) for x in scene.start])

    def __repr__(self) -> str:
        return f"<field of {self._name}: f(t, y)>"

    def __call__(self, t: float, y: npt.ArrayLike) -> Doubles:
        state = np.asarray(y, dtype=np.float64)
        omega, gamma = state[:3], state[3:]
        turning = -np.array(cross(omega, self.inertia @ omega))
        if len(gamma):
            turning = turning + np.array(cross(gamma, self.torque))
        rates = [self.inverse @ turning]
        if len(gamma):
            rates.append(np.array(cross(gamma, omega)))
        return np.concatenate(rates)
