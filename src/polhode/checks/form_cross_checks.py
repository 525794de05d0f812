"""Cross-checks between the forms of the equations: a few scenes in every form, in quad.

Evidence against a wrong equation in one form, not against what all share (the integrator).  Quad
shows a term that is wrong by 1e-28 of itself; compiling all forms for more digits would take four
times as long.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.judging.correct_digits import worst_digits
from polhode.runs.options import Options, choose_number
from polhode.runs.solve import solve
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.vocabulary import FORMS

SCENES = ("euler/turned-axes", "kovalevskaya/generic", "general/asymmetric-regular")
TIME = Fraction(10)
LEAST = 30.0  # digits
_OWN_STEPS = Options("taylor")  # refinement would take the principal form for others


@dataclass(frozen=True)
class CrossCheck:
    """One scene in one form: the digits to which it agrees with the principal form."""

    scene: str
    form: str
    digits: float | None
    note: str

    @property
    def passed(self) -> bool:
        """Whether it agrees, or the form does not take such a scene and says so."""
        return self.digits is None or self.digits >= LEAST


def cross_checks(tick: Callable[[str], None] | None = None) -> Iterator[CrossCheck]:
    """Each scene in each form against its principal form."""
    for name in SCENES:
        if tick is not None:
            tick(f"{name} in all forms")
        yield from _in_all_forms(name)


def _in_all_forms(name: str) -> list[CrossCheck]:
    scene = replace(library.load(name), outputs=(), events=(), form="principal").at([TIME])
    trusted = solve(scene, choose_number(scene, "quad", None), _OWN_STEPS, interruptible=False)
    return [_checked(form, trusted) for form in FORMS if form != scene.form]


def _checked(form: str, trusted: Trajectory) -> CrossCheck:
    scene = trusted.scene
    try:
        own = replace(scene, form=form)
        run = solve(own, trusted.number, _OWN_STEPS, interruptible=False)
    except BadInput as refusal:
        return CrossCheck(scene.name, form, None, f"refused: {refusal.expected}")
    if not run.outcome.done:
        return CrossCheck(scene.name, form, 0.0, run.outcome.value)
    digits = worst_digits(run.states, trusted.states, scene, trusted.number.most_digits)
    return CrossCheck(scene.name, form, digits, "agrees" if digits >= LEAST else "differs")
