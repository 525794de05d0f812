"""The checks of many cases as a result: what ``polhode check`` shows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

from polhode.checks.published_figures import WANTED, PrintedFigure, figures, textbook_digits
from polhode.common.errors import BadInput, counted, nearest, one_line
from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.common.values import ByValue
from polhode.judging.conditioning import Conditioning, conditioning
from polhode.judging.correct_digits import worst_digits
from polhode.judging.limits import LAST, UNKNOWN, expectation, limit_of, lost_digits
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.judging.score import STATE_PART, Score, score
from polhode.judging.tables.table import as_judged, of_run
from polhode.numbers import number_types
from polhode.numbers.decimals import decimal_string, shown
from polhode.results.cells import DOUBLE, TEXT
from polhode.results.result import Result
from polhode.results.table import Fact, Table, table_of_rows
from polhode.runs.options import Options, choose_number
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import FORMS

# --- regression -----------------------------------------------------------------------------------
#
# The library's regression: every case against its reference, digits inside a band.
#
# A band has a lower and an upper edge: fewer digits than expected are a loss, more mean that the
# yardstick is slack.  Published figures are held against the reference as well.


SPREAD = 1.0  # digits by which a run of another machine or version may have more or fewer
#: The number types for which bands are proposed.
PROPOSED = ("double", "extended", "quad")


@dataclass(frozen=True)
class NumberCheck:
    """One check: a case in one number type against its band.

    ``outcome``: how the run ended, ``ended`` whether as it should.  ``most_digits``: that its
    type can hold.  ``lost``: that no digits are left, and after which time; else empty.  ``limit``:
    what limits the digits, of a line that does not pass or where details were asked for; else
    empty.
    """

    number: str
    digits: float
    band: tuple[float, float] | None
    outcome: str
    ended: bool
    most_digits: float
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
        """A band about the digits of this run, to be pasted; None where there are none.

        It ends at the most digits that the type can hold, beyond which an upper edge says nothing.
        """
        if not self.ended or self.lost:
            return None
        most = math.ceil(10 * self.most_digits) / 10
        least = max(0.0, round(self.digits - SPREAD, 1))
        return least, min(round(self.digits + SPREAD, 1), most)

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
class CaseCheck:
    """What the checks of one case gave."""

    scene: Scene
    regime: str
    reference: str
    lines: tuple[NumberCheck, ...]
    figures: tuple[PrintedFigure, ...]
    textbook: float | None  # digits to which mpmath's own functions agree with the closed form

    @property
    def proposal(self) -> dict[str, tuple[float, float]]:
        """Bands by number type, of the runs that have digits left."""
        bands = {line.number: line.proposal for line in self.lines}
        return {number: band for number, band in bands.items() if band is not None}

    @property
    def passed(self) -> bool | None:
        """Whether everything stands; None where nothing says what should."""
        every = [*(x.passed for x in self.lines), *(x.passed for x in self.figures)]
        if self.textbook is not None and self.textbook < WANTED:
            every.append(False)  # two closed forms that agree are no check of a run
        verdicts = [passed for passed in every if passed is not None]
        return all(verdicts) if verdicts else None


def check_scene(scene: Scene, numbers: Sequence[str] = (), details: bool = True) -> CaseCheck:
    """The checks of one case: of its states, by runs without outputs and events.

    In the number types that it expects.  ``numbers``: these instead; a case without a band for one
    is run and shown without.  ``details``: whether what limits the digits is told of all lines, for
    which the motion is followed; else of those that do not pass.
    """
    reference = reference_of(scene)
    types = [*(numbers or scene.expect)]
    widest = sorted(types, key=number_types.NAMES.index, reverse=True)
    conditions: Conditioning | None = None
    if widest and details:
        conditions = conditioning(scene, number=number_types.named(widest[0]))
    lines: dict[str, NumberCheck] = {}
    earlier: Score | None = None  # whose rows of the reference judge the narrower types, too
    for number in widest:
        lines[number], latest = _report_line(scene, reference, number, conditions, earlier, details)
        earlier = earlier or latest
    rows, printed = tuple(lines[number] for number in types), tuple(figures(scene, reference))
    textbook = textbook_digits(reference)
    return CaseCheck(scene, reference.regime, reference.kind, rows, printed, textbook)


def _report_line(
    scene: Scene,
    reference: Reference,
    number: str,
    conditions: Conditioning | None,
    earlier: Score | None,
    details: bool,
) -> tuple[NumberCheck, Score | None]:
    """``conditions``: the scene's conditioning; ``earlier``: the score in a wider type.

    All that will be told is made here: the judgement does not go to another process, which would
    have to compute the reference again.
    """
    band = scene.expect.get(number)
    digits = number_types.DEFAULT_MP_DIGITS if number == "mp" else None
    # up to quad the bands are those of heyoka's own steps; mp as users get it, refined if faster
    options = Options("auto" if number == "mp" else "taylor", digits=digits)
    plain = replace(scene, outputs=(), events=())  # the digits are those of the state
    run = solve(plain, choose_number(scene, number, digits), options, interruptible=False)
    outcome, most = run.outcome.value, run.number.most_digits
    if not run.outcome.done:
        return NumberCheck(number, 0.0, band, outcome, False, most), None
    own = score(as_judged(of_run(run), scene), reference, earlier=earlier)
    line = NumberCheck(number, own.state_worst, band, outcome, True, most)
    limit = limit_of(own, STATE_PART)
    is_limit_told = details or not line.passed
    if own.state_worst < LAST or (is_limit_told and limit == UNKNOWN):
        expected = expectation(own, conditions)
        line = replace(line, lost=lost_digits(own.digits, expected))
        limit = limit_of(own, STATE_PART, expected)
    return replace(line, limit=limit) if is_limit_told else line, own


# --- form cross checks ----------------------------------------------------------------------------
#
# Cross-checks between the forms of the equations: a few scenes in every form, in quad.
#
# Evidence against a wrong equation in one form, not against what all share (the integrator). Quad
# shows a term that is wrong by 1e-28 of itself; compiling all forms for more digits would take
# four times as long.


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


def cross_checks(message: Message) -> Iterator[CrossCheck]:
    """Each scene in each form against its principal form."""
    for name in SCENES:
        message(f"{name} in all forms")
        scene = replace(library.load(name), outputs=(), events=(), form="principal").at([TIME])
        trusted = solve(scene, choose_number(scene, "quad", None), _OWN_STEPS, interruptible=False)
        yield from (_checked(form, trusted) for form in FORMS if form != scene.form)


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


# --- check report ---------------------------------------------------------------------------------


_MANY = 8  # cases: for fewer, processes of their own take longer to start than they save
_MARKS = {True: "ok  ", False: "FAIL", None: "--  "}
_WORDS = {True: "true", False: "false", None: ""}


@dataclass(frozen=True, repr=False, eq=False)
class CheckReport(Result, ByValue):
    """Cases against their references and bands, and the forms of the equations against each other.

    ``proposing``: whether bands are asked for, and not whether they hold.  ``interrupted``: whether
    Ctrl-C ended it, before all cases.
    """

    cases: Sequence[CaseCheck]
    forms: Sequence[CrossCheck]
    proposing: bool = False
    interrupted: bool = False

    def __repr__(self) -> str:
        return f"<CheckReport of {counted(len(self.cases), 'case')}: {self._verdict}>"

    @property
    def verdicts(self) -> list[bool]:
        """Of all that was judged, whether it stands."""
        every = [*(x.passed for x in self.cases), *(x.passed for x in self.forms)]
        return [passed for passed in every if passed is not None]

    @property
    def passed(self) -> bool | None:
        """Whether all stands, or all have bands to propose; None where nothing was judged."""
        if self.proposing:
            return all(report.proposal for report in self.cases)
        return all(self.verdicts) if self.verdicts else None

    @property
    def complete(self) -> bool:
        """Whether anything was judged."""
        return self.passed is not None

    @property
    def _verdict(self) -> str:
        good, judged = sum(self.verdicts), len(self.verdicts)
        left = len(self.cases) + len(self.forms) - judged
        return f"{good} passed, {judged - good} failed" + f", {left} without a band" * bool(left)

    def __str__(self) -> str:
        return self._text(details=False)

    def details(self) -> str:
        """All that was checked, of cases that pass, too."""
        return self._text(details=True)

    def _text(self, details: bool) -> str:
        lines: list[str] = []
        for report in self.cases:
            is_short = report.passed and not details and not self.proposing
            lines += [_line(report)] if is_short else _lines(report, self.proposing)
        for form in self.forms:
            digits = "" if form.digits is None else f"{form.digits:.1f} digits, "
            mark = _MARKS[form.passed]
            lines.append(f"{mark} {form.scene} in the form {form.form}: {digits}{form.note}")
        return "\n".join([*lines, self._verdict])

    def table(self) -> Table:
        """A row for each case and number type: its digits, its band, and the verdict."""
        rows = [
            (
                *(report.scene.name, report.regime, report.reference, line.number),
                *(None if line.lost else line.digits, *(line.band or (None, None))),
                *(line.outcome, _WORDS[line.passed], line.verdict, line.limit),
            )
            for report in self.cases
            for line in report.lines
        ]
        types = _texts("scene", "regime", "reference", "number")
        types |= dict.fromkeys(("correct_digits", "expected_least", "expected_most"), DOUBLE)
        types |= _texts("outcome", "passed", "verdict", "limit")
        return table_of_rows(types, rows, labels=4)

    def facts(self) -> list[Fact]:
        """Whether all passed; published figures, textbook's formulas, forms, and bands proposed."""
        published = [
            (
                *(report.scene.name, shown(x.published.t), x.published.quantity),
                *(x.published.value, x.ours, decimal_string(x.difference, 2), x.published.cite),
                *(x.verdict, _WORDS[x.passed]),
            )
            for report in self.cases
            for x in report.figures
        ]
        names = ("scene", "t", "quantity", "printed", "ours", "difference", "cite", "verdict")
        digits = {"digits": DOUBLE}
        textbook = [(x.scene.name, x.textbook) for x in self.cases if x.textbook is not None]
        forms = [(x.scene, x.form, x.digits, x.note, _WORDS[x.passed]) for x in self.forms]
        proposed = [
            (report.scene.name, number, *band)
            for report in self.cases
            for number, band in report.proposal.items()
        ]
        of_forms = _texts("scene", "form") | digits | _texts("note", "passed")
        bands = _texts("scene", "number") | dict.fromkeys(("least", "most"), DOUBLE)
        return [
            Fact("passed", self.passed, "whether all stands that was judged"),
            Fact("published", table_of_rows(_texts(*names, "passed"), published)),
            Fact("textbook", table_of_rows(_texts("scene") | digits, textbook)),
            Fact("forms", table_of_rows(of_forms, forms, labels=2)),
            *([Fact("proposed", table_of_rows(bands, proposed, labels=2))] * self.proposing),
        ]


def _texts(*names: str) -> dict[str, str]:
    """Columns of texts."""
    return dict.fromkeys(names, TEXT)


def check_cases(
    scenes: Sequence[Scene | str | Path] = (),
    forms: bool = False,
    number: Sequence[str] = (),
    propose: bool = False,
    details: bool = False,
    message: Message | None = None,
) -> CheckReport:
    """Check cases against references and published figures, and the forms against each other.

    Parameters
    ----------
    scenes : sequence of str or Path
        Names, patterns or paths; without any all that ship, and the forms.
    forms : bool
        Cross-checks between the forms, alone or after SCENEs.
    number : sequence of str
        These number types instead of the case's.
    propose : bool
        Run SCENEs in double, extended and quad, and print [expect] bands to paste.
    details : bool
        All that was checked, of cases that pass, too, and what limits their digits.
    message : callable, optional
        Called with the name of what is checked.
    """
    if propose and not scenes:
        raise BadInput("check", "--propose", None, "SCENEs to propose bands for")
    for name in number:
        if name not in number_types.NAMES:
            raise BadInput("check", "number", name, nearest(name, list(number_types.NAMES)))
    numbers = tuple(number or (PROPOSED if propose else ()))
    solve = partial(check_scene, numbers=numbers, details=details or propose)
    say = message or (lambda text: None)
    reports: list[CaseCheck] = []
    crossed: list[CrossCheck] = []

    try:
        if scenes or not forms:
            cases = [library.load(name) for name in library.matching([*map(str, scenes)])]
            if not cases:
                raise BadInput("check", "SCENE", None, "a path: no cases are installed")
            shared = min(cores(), len(cases)) if len(cases) >= _MANY else 1
            reports.extend(in_order(solve, cases, shared, lambda scene: say(scene.name)))
        if forms or not (scenes or number):
            crossed.extend(cross_checks(say))
    except KeyboardInterrupt:
        return CheckReport(reports, crossed, propose, interrupted=True)
    return CheckReport(reports, crossed, propose)


def _head(report: CaseCheck) -> str:
    return f"{_MARKS[report.passed]} {report.scene.name} ({report.regime}, {report.reference})"


def _line(report: CaseCheck) -> str:
    """A case that passes, in one line."""
    digits = [f"{line.number} {line.lost or f'{line.digits:.2f} digits'}" for line in report.lines]
    if report.figures:
        digits.append(counted(len(report.figures), "published figure"))
    return f"{_head(report)}: {', '.join(digits)}"


def _lines(report: CaseCheck, proposing: bool) -> Iterator[str]:
    """What is told of a case."""
    yield _head(report)
    for line in report.lines:
        band = "" if line.band is None else f" in [{line.band[0]:g}, {line.band[1]:g}]"
        why = line.limit and f", limited by {line.limit}"
        digits = line.lost or f"{line.digits:6.2f} digits"
        yield f"     {line.number:<9}{digits}{band}: {line.verdict}{why}"
    if report.textbook is not None:
        yield f"     mpmath's own functions agree to {report.textbook:.1f} digits"
    for figure in report.figures:
        p = figure.published
        yield f"     {p.quantity} at t = {shown(p.t)}: {figure.verdict}  ({one_line(p.cite)})"
        yield f"         printed {p.value}"
        yield f"         ours    {figure.ours}"
    if proposing:
        bands = [f"{name:<8} = [{low}, {high}]" for name, (low, high) in report.proposal.items()]
        yield from ["", "[expect]", *bands, ""] if bands else ["     no digits are left: no band"]
