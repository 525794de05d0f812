"""The integrator of a system: built, or taken up again where one of the same equations is idle."""

from __future__ import annotations

from fractions import Fraction

from polhode.equations.system import System
from polhode.numbers.number_types import NumberType
from polhode.scenes.vocabulary import ANGLE_VARIABLES
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS
from polhode.taylor.integrator.protocols import Corrector, Watcher
from polhode.taylor.integrator.specification import Blueprint
from polhode.taylor.integrator.stepping import Integrator


def blueprint(system: System, number: NumberType, tolerance: Fraction | None = None) -> Blueprint:
    """What an integrator of a system is built from; ``tolerance``: of a step, eps unless given."""
    form = system.form
    plain = form.scene.form == "principal"  # what is left of it is among the names
    return Blueprint(
        system.names,
        lambda state, k: system.field(state, k, EXPRESSIONS),
        system.coefficients,
        system.start,
        number,
        tolerance,
        lambda state, k: form.distance(state[: len(form.variables)], k, EXPRESSIONS),
        (system.outputs, system.still) if plain else None,
        len(ANGLE_VARIABLES) if "angles" in system.outputs else 0,
    )


def build(
    system: System,
    number: NumberType,
    tolerance: Fraction | None = None,
    origin: Fraction = Fraction(0),
    watcher: Watcher | None = None,
    corrector: Corrector | None = None,
) -> Integrator:
    """A heyoka integrator of a system that stands at its start at time ``origin``.

    ``watcher``: looks for events.  ``corrector``: puts the state back now and then.  Raises
    OutOfRange for numbers that the type cannot hold.
    """
    return Integrator(blueprint(system, number, tolerance), origin, watcher, corrector)
