"""The library's regression: every case against its reference, digits inside a band.

A band has a lower and an upper edge: fewer digits than expected are a loss, more mean that the
yardstick is slack.  Published figures are held against the reference as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from polhode.checks.published_figures import PrintedFigure, figures
from polhode.checks.textbook_digits import WANTED, textbook_digits
from polhode.common import processes as of_work
from polhode.common.errors import BadInput, nearest
from polhode.judging.conditioning.conditioning import Conditioning, conditioning
from polhode.judging.references.reference import AnyReference
from polhode.judging.references.reference import reference as reference_of
from polhode.judging.score.compare import compare
from polhode.judging.score.judgement import Judgement
from polhode.numbers import number_types
from polhode.runs.options import Options, choose_number
from polhode.runs.solve import solve
from polhode.scenes import library
from polhode.scenes.scene import Scene

SPREAD = 1.0  # digits by which a run of another machine or version may have more or fewer
#: The number types for which bands are proposed.
PROPOSED = ("double", "extended", "quad")
TICK = Callable[[str], None]


@dataclass(frozen=True)
class Line:
    """One check: a case in one number type against its band.

    ``outcome``: how the run ended, ``ended`` whether as it should.  ``lost``: that no digits are
    left, and after which time; else empty.  ``limit``: what limits the digits, of a line that does
    not pass or where details were asked for; else empty.
    """

    number: str
    digits: float
    band: tuple[float, float] | None
    outcome: str
    ended: bool
    lost: str = ""
    limit: str = ""

    @property
    def passed(self) -> bool | None:
        """Whether the run ended as it should, its digits inside the band; None without a band."""
        if not self.ended:
            return False
        return None if self.band is None else self.band[0] <= self.digits <= self.band[1]

    @property
    def proposal(self) -> tuple[float, float] | None:
        """A band about the digits of this run, to be pasted; None where there are none."""
        if not self.ended or self.lost:
            return None
        return max(0.0, round(self.digits - SPREAD, 1)), round(self.digits + SPREAD, 1)

    @property
    def verdict(self) -> str:
        """In words."""
        if not self.ended:
            return self.outcome
        if self.band is None:
            return "no band to hold it against"
        if self.digits < self.band[0]:
            return "too few digits"
        return "inside" if self.passed else "more digits than the case can have"


@dataclass(frozen=True)
class Report:
    """What the checks of one case gave."""

    scene: Scene
    regime: str
    reference: str
    lines: tuple[Line, ...]
    figures: tuple[PrintedFigure, ...]
    textbook: float | None  # digits to which mpmath's own functions agree with the closed form

    @property
    def proposal(self) -> dict[str, tuple[float, float]]:
        """Bands by number type, of the runs that have digits left."""
        found = {line.number: line.proposal for line in self.lines}
        return {number: band for number, band in found.items() if band is not None}

    @property
    def passed(self) -> bool | None:
        """Whether everything stands; None where nothing says what should."""
        every = [*(x.passed for x in self.lines), *(x.passed for x in self.figures)]
        if self.textbook is not None and self.textbook < WANTED:
            every.append(False)  # two closed forms that agree are no check of a run
        found = [passed for passed in every if passed is not None]
        return all(found) if found else None


def check(
    patterns: Sequence[str] = (),
    numbers: Sequence[str] = (),
    tick: TICK | None = None,
    workers: int = 1,
    details: bool = True,
) -> Iterator[Report]:
    """Check cases (all that ship, or names, patterns, paths) in the number types that they expect.

    ``numbers``: these types instead; a case without a band for one is run and shown without.
    ``workers``: processes that share the cases.  ``details``: whether what limits the digits is
    told of all lines, for which the motion is followed; else of those that do not pass.
    """
    for number in numbers:
        if number not in number_types.NAMES:
            raise BadInput("check", "number", number, nearest(number, list(number_types.NAMES)))
    scenes = [library.load(name) for name in library.matching(list(patterns))]
    if not scenes:
        raise BadInput("check", "SCENE", None, "a path: no cases are installed")

    def begun(scene: Scene) -> None:
        if tick is not None:
            tick(scene.name)

    solve = partial(check_scene, numbers=tuple(numbers), details=details)
    yield from of_work.in_order(solve, scenes, min(workers, len(scenes)), begun)


def check_scene(scene: Scene, numbers: Sequence[str] = (), details: bool = True) -> Report:
    """The checks of one case: of its states, by runs without outputs and events.

    ``details``: as of :func:`check`.
    """
    reference = reference_of(scene)
    wanted = [*(numbers or scene.expect)]
    widest = sorted(wanted, key=number_types.NAMES.index, reverse=True)
    known: Conditioning | Judgement | None = None
    if widest and details:
        known = conditioning(scene, number=number_types.named(widest[0]))
    lines: dict[str, Line] = {}
    for number in widest:
        lines[number], judged = _line(scene, reference, number, known, details)
        if not isinstance(known, Judgement):  # whose rows of the reference judge the others, too
            known = judged or known
    return Report(
        scene,
        reference.regime,
        reference.kind,
        tuple(lines[number] for number in wanted),
        tuple(figures(scene, reference)),
        textbook_digits(reference),
    )


def _line(
    scene: Scene,
    reference: AnyReference,
    number: str,
    known: Conditioning | Judgement | None,
    details: bool,
) -> tuple[Line, Judgement | None]:
    """``known``: the scene's conditioning, or a judgement in a wider type.

    All that will be told is made here: the judgement does not go to another process, which would
    have to compute the reference again.
    """
    band = scene.expect.get(number)
    digits = number_types.DEFAULT_MP_DIGITS if number == "mp" else None
    # up to quad the bands are those of heyoka's own steps; mp as users get it, refined if faster
    options = Options("auto" if number == "mp" else "taylor", digits=digits)
    plain = replace(scene, outputs=(), events=())  # the digits are those of the state
    run = solve(plain, choose_number(scene, number, digits), options, interruptible=False)
    outcome = run.outcome.value
    if not run.outcome.done:
        return Line(number, 0.0, band, outcome, ended=False), None
    judged = compare(run, reference, known=known)
    line = Line(number, judged.state_worst, band, outcome, ended=True, lost=judged.lost)
    if details or not line.passed:
        line = replace(line, limit=judged.limit)
    return line, judged
