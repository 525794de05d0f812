"""Two integrations as the reference of a scene, where it asks for them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput
from polhode.common.result import Result
from polhode.judging.correct_digits import worst_digits
from polhode.numbers import number_types
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Rows
from polhode.numbers.scalars import AnyNumber, Real
from polhode.scenes.classification import kind_of_body
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene


class TwoPrecisions(Result):
    """A reference made by two integrations at different precision, if a scene asks for it.

    It shares the integrator and the equations with the runs that it judges: evidence against
    rounding and truncation, not against a wrong equation; its errors are called estimated.
    ``agreement`` holds the correct digits to which the two integrations of the last request agree.

    >>> import polhode
    >>> twice = polhode.TwoPrecisions(polhode.load("general/asymmetric-regular"))
    >>> rows = twice.at([1], digits=20)
    >>> 20 <= twice.agreement < 30
    True
    """

    is_closed_form = is_proven = False
    kind = "two-precisions"
    period = None
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.regime = kind_of_body(scene.body)
        self.agreement = float("nan")
        self.frequencies: dict[str, Real] = {}
        self._known: dict[tuple[tuple[Exact, ...], int], tuple[Rows, float]] = {}

    def __eq__(self, other: object) -> bool:
        return self.scene == other.scene if isinstance(other, TwoPrecisions) else NotImplemented

    def __reduce__(self) -> tuple[object, ...]:
        return TwoPrecisions, (self.scene,)

    def __repr__(self) -> str:
        return f"<TwoPrecisions of {self.scene.name}: {self.regime}>"

    def at(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows p q r gamma1 gamma2 gamma3 as mpf, to so many digits; see ``agreement``.

        Raises BadInput where the two integrations cannot be made to agree to so many digits.
        """
        digits = whole(self.scene.name, "digits", digits, 1, number_types.MOST_ASKED)
        key = (
            each(self.scene.name, "t", times, reader(self.scene.units, TIME), "a list of times"),
            digits,
        )
        if key not in self._known:
            self._known[key] = self._integrated(*key)
        rows, self.agreement = self._known[key]
        return [list(row) for row in rows]

    def _integrated(self, times: tuple[Exact, ...], digits: int) -> tuple[Rows, float]:
        from polhode.runs.problem.options import Options
        from polhode.runs.solve import solve

        # The coarse run has some digits to spare, the fine one 12 more; where a motion multiplies
        # errors, what was lost is added and both are made again.
        plain = replace(self.scene, events=(), form="principal")
        scene, spare = plain.at(times), 4
        for _ in range(4):
            coarse_type = number_types.mp_for(digits + spare, scene.log10_angle)
            fine_type = number_types.NumberType("mp", coarse_type.bits + 40)
            coarse, fine = (
                solve(scene, kind, Options("taylor"), interruptible=False)
                for kind in (coarse_type, fine_type)
            )
            if not (coarse.outcome.done and fine.outcome.done):
                break
            agreement = worst_digits(coarse.states, fine.states, scene, cap=coarse_type.most_digits)
            if agreement >= digits:
                return fine.states, agreement
            spare += digits - int(agreement) + 4
        expected = f"a motion that keeps {digits} digits to t = {float(times[-1]):g}"
        raise BadInput(scene.name, "reference", None, expected)

    def attitude(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Not made: the reference integrates the state alone."""
        raise BadInput(self.scene.name, "reference", None, "a closed form for the attitude")

    def angles(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real | None]]:
        """Not made, likewise."""
        raise BadInput(self.scene.name, "reference", None, "a closed form for the angles")
