"""A certificate of an enclosure: its statement, and guesses that an independent program needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.scenes.scene import Scene

#: Middle and radius as decimals.
Ball: TypeAlias = tuple[str, str]

#: The part of the time that guesses take; the check, which takes the rest, counts from 0 again.
MAKING = 0.2

_SPARE = 28  # bits beyond the smallest radius
_MORE = (0, 48, 112, 192)  # bits, where those are too few
_SHARPEST = 2.0**-20  # a radius is no smaller a part of the largest at its time


def certificate(
    scene: Scene,
    times: Sequence[Exact],
    balls: Sequence[Sequence[Ball]],
    progress: Progress | None = None,
    turn: Sequence[Exact] = (),
) -> JsonObject:
    """The certificate, as JSON's objects, that states and attitude lie in balls at certain times.

    ``balls``: rows of six, of ten with the attitude; ``turn``: the quaternion at t = 0 then.  It is
    checked, with more bits where that does not succeed at once.  Raises BadInput for what has no
    certificate.
    """
    check(scene, times)
    claimed = [
        (t, _widened(row))
        for t, row in zip(times, balls, strict=True)
        if t != 0 and isinstance(t, Fraction)  # at 0 the scene itself says it
    ]
    statement = [
        {"t": str(t), "balls": [list(ball) for ball in row[:6]]}
        | ({"attitude": [list(ball) for ball in row[6:]]} if row[6:] else {})
        for t, row in claimed
    ]
    last = max((t for t, _ in claimed), key=abs)
    least = min(float(radius) for _, row in claimed for _, radius in row)
    fewest = max(verify.COARSE, math.ceil(-math.log2(least))) + _SPARE
    fault = ""
    for bits in (fewest + more for more in _MORE):
        numbers = _numbers(scene, turn, bits + verify.COARSE)
        with ctx.workprec(bits + 2 * verify.COARSE):
            _, _, start = verify.balls_of(verify.read_scene(numbers))
            making = _part_of(progress, 0.0, MAKING)
            guesses = certificate_file.steps(numbers, start[:6], last, bits, progress=making)
        document = {
            "format": verify.FORMAT,
            "kind": "state",
            "scene": numbers,
            **guesses._asdict(),
            "statement": statement,
        }
        try:
            by_checker(verify.state, document, _part_of(progress, MAKING, 1.0))
            return document
        except verify.NotProved as refused:
            fault = str(refused)
        except verify.Damaged as refused:
            fault = str(refused)
            break
    raise BadInput(scene.name, "certificate", fault, "a statement that its own checker proves")


def _part_of(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """What shows the progress of a part of the work, which is all from ``begin`` to ``end``."""
    if progress is None:
        return None
    return lambda fraction, steps: progress(begin + (end - begin) * fraction, steps)


def check(scene: Scene, times: Sequence[Exact]) -> None:
    """Raise BadInput where the states of a scene at certain times have no certificate."""
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, for a certificate")
    for t in times:
        if not isinstance(t, Fraction):
            raise BadInput(scene.name, "at", shown(t), "rational times, for a certificate")
    rational = [t for t in times if isinstance(t, Fraction)]
    if not any(rational):
        raise BadInput(scene.name, "at", "0", "a time other than 0, for a certificate")
    if min(rational) < 0 < max(rational):
        raise BadInput(scene.name, "at", None, "times of one sign, for a certificate")


def _widened(row: Sequence[Ball]) -> list[Ball]:
    """Balls of one time of which none is far smaller than the others: they cost bits."""
    least = max(float(radius) for _, radius in row) * _SHARPEST
    return [
        (middle, radius if float(radius) >= least else f"{least:.2e}") for middle, radius in row
    ]


def _numbers(scene: Scene, turn: Sequence[Exact], bits: int) -> JsonObject:
    """The scene's exact numbers as texts, irrational ones as balls."""
    vectors: dict[str, Sequence[Exact]] = {"omega": scene.omega, "gamma": scene.gamma or ()}
    if turn:
        vectors["attitude"] = turn
    texts = {key: [certificate_file.number(x, bits) for x in v] for key, v in vectors.items()}
    return {**certificate_file.body_numbers(scene.body, bits), **texts}
