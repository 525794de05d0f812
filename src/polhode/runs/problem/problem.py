"""What every run of a scene in one number type begins with: made once, kept with the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.cached_property import cached_property
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import Form, equations
from polhode.equations.readout import Readout
from polhode.equations.system import System, system
from polhode.numbers.conversion import joined, number_value, to_extended
from polhode.numbers.exact import sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Rows
from polhode.numbers.scalars import EXACT, Row
from polhode.runs.problem.options import rounded_times
from polhode.scenes.scene import Scene
from polhode.taylor.backend.time_grid import Times

if TYPE_CHECKING:
    from polhode.taylor.integrator.specification import Blueprint


@dataclass(frozen=True, eq=False)
class Setup:
    """What depends on a scene, a number type and a tolerance, but not on the output times.

    ``inputs``: the narrower type that start and coefficients are rounded to first, if any.
    """

    scene: Scene
    number: NumberType
    tolerance: Fraction | None = None
    inputs: NumberType | None = None

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone: what is made from them is made again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def unit(self) -> Fraction:
        """The run's own unit of time."""
        return Fraction(2) ** self.scene.time_unit

    @cached_property
    def read(self) -> Readout:
        """Reads the run's rows."""
        return Readout(self.scene, self.number)

    @cached_property
    def form(self) -> Form:
        """The form of the equations."""
        return equations(self.scene)

    @cached_property
    def still(self) -> bool:
        """Whether the state need not be integrated: it is that of a relative equilibrium."""
        principal_form = self.scene.form == "principal" and self.inputs is None
        return principal_form and equilibrium.at_rest(self.scene).state

    @cached_property
    def singular(self) -> bool:
        """Whether the start is too near to the singular set of the form."""
        from polhode.taylor.integrator.singularities import nearest

        away = self.form.distance(self.form.start, self.form.coefficients, EXACT)
        return away is not None and bool(away <= nearest(self.number))

    @cached_property
    def apart(self) -> bool:
        """Whether attitude and angles may be had from a plain run's states, in double and extended.

        Not beside events, whose expressions take part in choosing the steps, and no angles from a
        pole on (polhode.runs.observers.attitude_lanes).
        """
        scene = self.scene
        return (
            self.number.flat
            and bool(scene.modelled)
            and scene.form == "principal"
            and scene.gamma is not None
            and not scene.events
            and not self.still
            and not ("angles" in scene.modelled and scene.starts_at_pole)
        )

    @property
    def full(self) -> bool:
        """Whether inputs and steps are as accurate as the number type is."""
        tolerance = self.tolerance
        return self.inputs is None and (tolerance is None or tolerance <= self.number.eps)

    @cached_property
    def whole(self) -> System:
        """The equations with all that the outputs ask for."""
        return self.rounded(system(self.scene, self.scene.modelled))

    @cached_property
    def blueprint(self) -> Blueprint:
        """What an integrator of the whole is built from."""
        from polhode.taylor.integrator.build import blueprint

        return blueprint(self.whole, self.number, self.tolerance)

    @cached_property
    def first(self) -> Rows:
        """The start of the whole as the one row of a run; not to be written to."""
        return self.rows([[number_value(x, self.number) for x in self.whole.start]])

    @cached_property
    def turn(self) -> Any | None:
        """The form's axes along the scene's, rows of longdoubles; None where they are the same."""
        import numpy as np

        axes = self.form.axes
        return None if axes.trivial else np.array([[to_extended(x) for x in v] for v in axes.rows])

    @cached_property
    def attitude(self) -> Any:
        """The quaternion at the start, of the scene's axes, and psi: longdoubles."""
        import numpy as np

        assert self.scene.gamma is not None
        q = kinematics.starting_attitude(self.scene.gamma, self.scene.psi)
        return np.array([to_extended(x) for x in (*q, self.scene.psi)])

    def rounded(self, what: System) -> System:
        """A system with its inputs rounded to the narrower type, where that was asked for."""
        return what if self.inputs is None else what.rounded(self.inputs)

    def rows(self, rows: Sequence[Row]) -> Rows:
        """Rows of the run's numbers, as a run holds them: an array, or a list above extended."""
        if not self.number.flat:
            return list(rows)
        import numpy as np

        width = len(rows[0]) if rows else len(self.whole.start)
        wide = np.array(rows, dtype=np.longdouble).reshape(-1, width)
        return wide if self.number.name == "extended" else wide.astype(np.float64)

    def joined(self, parts: Sequence[Rows]) -> Rows:
        """Several parts' rows in one."""
        return joined(parts, self.number)


def setup(
    scene: Scene,
    number: NumberType,
    tolerance: Fraction | None = None,
    inputs: NumberType | None = None,
) -> Setup:
    """The set-up of such runs, from the scene where it is kept, shared by scenes of other times.

    Not by those that go the other way in time: events count what crosses on the way.
    """
    key = (setup, number, tolerance, inputs, sign(scene.end) >= 0)
    found = scene.kept.get(key)
    if not isinstance(found, Setup):
        found = scene.kept[key] = Setup(scene, number, tolerance, inputs)
    return found


def bare(made: Setup) -> Setup:
    """The set-up of the same run without outputs and events, from the scene where it is kept."""
    scene = made.scene.kept.get(bare)
    if scene is None:
        scene = made.scene.kept[bare] = replace(made.scene, outputs=(), events=())
    return setup(scene, made.number, made.tolerance, made.inputs)


class Asked(NamedTuple):
    """Times rounded to a run's type: ``exact``, and ``inside`` its own unit."""

    exact: Sequence[Fraction]
    inside: Times


def asked(scene: Scene, number: NumberType) -> Asked:
    """The output times of a scene's runs, from the scene where they are kept."""
    found = scene.kept_of_times.get(number)
    if not isinstance(found, Asked):
        exact = tuple(rounded_times(scene, number))
        unit = Fraction(2) ** scene.time_unit
        inside = Times(exact if unit == 1 else [t / unit for t in exact], number)
        found = scene.kept_of_times[number] = Asked(exact, inside)
    return found
