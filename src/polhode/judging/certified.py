"""A proven enclosure as the reference of a scene, where no closed form is known."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import TIME, reader
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import AnyNumber, Real
from polhode.results.result import Storable
from polhode.results.table import Content
from polhode.scenes.body import kind_of_body
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.enclosures.result import Enclosure


SAVED_DIGITS = 30


class NoAnswer(BadInput):
    """That a reference has no answer to a question that another one may answer."""


class ProofTooLong(BadInput):
    """That a proof would take longer than it may."""


class Certified(Storable):
    """The reference of any scene: balls that contain the exact motion, and their midpoints.

    Answers are in the scene's body axes and units.  ``progress``, ``forecast``: called during each
    proof as by :func:`polhode.certify`; ``max_seconds``: a limit on all of them together, from now
    on.  ``agreement`` holds the digits proven for the last request of states, at its worst time; if
    states were never asked for, of the last attitude or angles.

    >>> import polhode
    >>> proven = polhode.Certified(polhode.load("general/asymmetric-regular"))
    >>> rows = proven.at([1], digits=20)
    >>> 20 <= proven.agreement < 30
    True
    """

    is_closed_form = False
    is_dear = False
    encloses_attitude = True
    proven = True
    kind = "certified"
    period = None
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self,
        scene: Scene,
        *,
        progress: Progress | None = None,
        forecast: Callable[[float], None] | None = None,
        max_seconds: float | None = None,
    ) -> None:
        self.scene = scene
        self._told = progress, forecast
        self._most, self._deadline = (
            max_seconds,
            math.inf if max_seconds is None else time.monotonic() + max_seconds,
        )
        self.regime = kind_of_body(scene.body)
        self.agreement, self._states_asked = math.nan, False
        self.frequencies: dict[str, Real] = {}
        self._proofs: list[tuple[tuple[Exact, ...], tuple[str, ...], Enclosure]] = []

    def __eq__(self, other: object) -> bool:
        return self.scene == other.scene if isinstance(other, Certified) else NotImplemented

    def __reduce__(self) -> tuple[object, ...]:
        return Certified, (self.scene,)

    def __repr__(self) -> str:
        return f"<Certified of {self.scene.name}: {self.regime}>"

    def content(self) -> Content:
        """What a file of :meth:`proof` holds."""
        return self.proof.content()

    @property
    def proof(self) -> Enclosure:
        """The enclosure at the times of the scene, to 30 digits: what is saved."""
        return self.enclosure(self.scene.times, SAVED_DIGITS, self.scene.outputs)

    def save(self, path: str | Path) -> None:
        """Write :attr:`proof` to a file, as :meth:`polhode.Enclosure.save` does."""
        self.proof.save(path)

    def at(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf, proven to ``digits`` digits.

        Raises BadInput where that many cannot be proven.
        """
        enclosure = self.enclosure(times, digits)
        self._states_asked = True
        return [list(row) for row in enclosure.midpoints]

    def enclosure(
        self, times: Iterable[AnyNumber], digits: int = 50, outputs: tuple[str, ...] = ()
    ) -> Enclosure:
        """The balls themselves; the last request is also told in ``agreement``.

        What was proven to as many digits or more at the same times is not proven again.
        """
        from polhode.enclosures.certify import certify  # a closed form needs no heyoka
        from polhode.enclosures.task import MOST_DIGITS

        digits = whole(self.scene.name, "digits", digits, 1, MOST_DIGITS)
        scene = self.scene
        instants = each(scene.name, "t", times, reader(scene.units, TIME), "a list of times")
        proofs = (x for at, of, x in self._proofs if at == instants and of == outputs)
        enclosure = next((proof for proof in proofs if proof.asked >= digits), None)
        if enclosure is None:
            progress, forecast = self._told
            left = None if self._most is None else max(1e-3, self._deadline - time.monotonic())
            enclosure = certify(
                replace(self.scene, outputs=outputs),
                instants,
                digits=digits,
                progress=progress,
                max_seconds=left,
                forecast=forecast,
            )
            if enclosure.outcome is Outcome.TIME_LIMIT:
                last = shown(max(instants, key=abs))
                expected = f"seconds in which the motion is proven to t = {last}, or earlier times"
                raise ProofTooLong(self.scene.name, "max_seconds", self._most, expected)
            if not enclosure.outcome.done:
                raise KeyboardInterrupt
            self._proofs.append((instants, outputs, enclosure))
        self.agreement = enclosure.proven
        return enclosure

    def attitude(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows q0 q1 q2 q3 as mpf, the quaternion body to space, proven to ``digits`` digits."""
        enclosure = self._with("attitude", times, digits)
        assert enclosure.attitude is not None
        rows = enclosure.attitude.midpoints(enclosure.noise + 128)
        return [[x for x in row if x is not None] for row in rows]  # an attitude has no gaps

    def angles(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real | None]]:
        """Rows psi theta phi in radians, continuous, proven to ``digits`` digits.

        psi and phi are proven up to whole turns, which are followed in doubles.  They are None at a
        start at a pole, and at all times where the third axis stays vertical.  Raises BadInput
        where a motion passes so close to a pole that it is not known on which side.
        """
        enclosure = self._with("angles", times, digits)
        assert enclosure.angles is not None
        unknown = [
            t
            for row, t in zip(enclosure.angles.centres, enclosure.times, strict=True)
            if row[0] is None
        ]
        if any(t != 0 for t in unknown) and not self._stays_at_a_pole:
            since = ", ".join(f"{t:.6g}" for t in enclosure.lost)
            expected = (
                f"a motion that keeps away from the poles: psi and phi are lost at t = {since}"
            )
            raise NoAnswer(self.scene.name, "angles", None, expected)
        return enclosure.angles.midpoints(enclosure.noise + 128)

    @property
    def _stays_at_a_pole(self) -> bool:
        from polhode.equations.kinematics import departure

        return self.scene.starts_at_pole and departure(self.scene) is None

    def _with(self, output: str, times: Iterable[AnyNumber], digits: int) -> Enclosure:
        if self.scene.gamma is None:
            raise BadInput(self.scene.name, "start.gamma", None, "a unit vector, for an attitude")
        agreement = self.agreement
        enclosure = self.enclosure(times, digits, (output,))
        self.agreement = agreement if self._states_asked else min(getattr(enclosure, output).digits)
        return enclosure
