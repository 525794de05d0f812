"""Results as JSON objects; names and shapes are a contract."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from polhode.equations.column import Texts, column, derived_words
from polhode.judging.diagnosis.error_budget import is_lost
from polhode.judging.references.right_rows import right_rows
from polhode.motion.outcomes import EventTimes
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import in_full, is_decimal, strings
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath, own
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Real
from polhode.output.json_object import JsonObject
from polhode.runs.trajectory import Trajectory
from polhode.scenes.classification import kind_of_body
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS

if TYPE_CHECKING:  # a run needs none of these
    from polhode.enclosures.events import CertifiedEvents
    from polhode.enclosures.result import Enclosure
    from polhode.equations.integrals import Drift
    from polhode.judging.conditioning.lyapunov import Lyapunov
    from polhode.judging.convergence_order import ObservedOrder
    from polhode.judging.references.reference import Reference
    from polhode.judging.references.textbook import Textbook
    from polhode.judging.score.judgement import Judgement


def of_run(run: Trajectory, regime: str) -> JsonObject:
    """The object that ``run --json`` prints."""
    answer: JsonObject = {
        "scene": run.scene.name,
        "number": run.number.name,
        "bits": run.number.bits,
    }
    if run.digits is not None:
        answer["digits"] = run.digits
    if run.correct_digits is not None:
        answer["correct_digits"] = round_down(run.correct_digits)
        answer["checked_by"] = run.checked_by
    answer |= {
        "form": run.scene.form,
        "method": run.method,
        "regime": regime,
        "columns": list(run.columns),
        "times": run.time_strings(),
        "states": run.state_strings(),
    }
    if run.errors is not None:
        answer["error"] = [None if x is None else f"{x:.1e}" for x in run.errors]
        answer["proven"] = False
    answer |= {
        word: of_column(word, answer["states"], strings(rows, run.number))
        for word, rows in run.outputs.items()
        if word in run.scene.outputs
    }
    if run.scene.events:
        answer["events"] = [of_event(event, run.number) for event in run.events]
    if run.projection is not None:
        answer["projection"] = {
            "onto": list(run.projection.onto),
            "every": run.projection.every,
            "count": run.projection.count,
            "largest": f"{run.projection.largest:.3e}",
            "sum": f"{run.projection.sum:.3e}",
        }
    if run.correct_digits is None:
        answer["digits_left"] = [round_down(x) for x in run.expected.digits]
        after = run.expected.lost_after
        answer["no_digits_left_after"] = None if after is None else float(f"{after:.3g}")
    answer |= {
        "drift": of_drift(run.drift),
        "outcome": run.outcome.value,
        "reached": in_full(run.reached),
        "steps": run.steps,
        "provenance": dict(run.provenance),
    }
    return answer


def round_down(digits: float) -> float:
    """Digits to two places, never more than there are."""
    return math.floor(100 * digits) / 100


def of_column(word: str, states: Texts, rows: Texts) -> object:
    """An output's rows as JSON has them; all of them are decimal strings."""
    shape = column(word).as_json if word in derived_words() else None
    return rows if shape is None else shape(states, rows)


def rows_of_column(word: str, shown: Any) -> Texts:
    """The way back: an output's rows of what JSON has."""
    read = column(word).from_json if word in derived_words() else None
    rows: Texts = shown if read is None else read(shown)
    return rows


def of_event(event: EventTimes, number: NumberType) -> JsonObject:
    """When an event happened, in which direction, how surely, and the states then."""
    return {
        "name": event.name,
        "times": event.time_strings(),
        "states": strings(event.states, number),
        "signs": list(event.signs),
        "grazing": list(event.grazing),
        "uncertainty": [f"{x:.1e}" for x in event.uncertainty],
        "depths": [f"{x:.1e}" for x in event.depths],
        "complete": event.complete,
    }


def of_drift(drift: Drift) -> dict[str, str | None]:
    """Drift as decimal strings."""
    return {
        name: None if value is None else f"{value:.3e}" for name, value in drift._asdict().items()
    }


def of_reference(
    reference: Reference | Textbook, times: Sequence[Exact], digits: int
) -> JsonObject:
    """The object that ``reference --json`` prints: the closed form to so many digits."""
    scene = reference.scene
    number = NumberType("mp", number_types.bits_for(digits + 1))
    printed = number.printed_digits
    held = held_times(scene, times, digits)
    states = right_rows(reference.at, held, printed)
    answer: JsonObject = {
        "scene": scene.name,
        "number": "mp",
        "bits": number.bits,
        "digits": digits,
        "form": reference.kind,
        "regime": reference.regime,
        "reference": reference.kind,
        "columns": list(scene.columns),
        "times": [in_full(exactly(t)) for t in held],
        "states": strings(states, number),
    }
    if (radii := reference.radii(held, printed)) is not None:
        pairs = zip(states, radii, strict=True)
        answer["radii"] = [[*map(partial(_radius, printed), *pair)] for pair in pairs]
    for word in COLUMNS:
        if word in scene.outputs:
            rows = right_rows(partial(reference.column, word), held, printed)
            answer[word] = of_column(word, answer["states"], strings(rows, number))
    answer |= {"outcome": "reached end", "steps": 0, "provenance": scene.provenance()}
    return answer | {"proven": reference.proven}


def _radius(printed: int, x: Real, radius: Real) -> str:
    """A bound of the error of x as it is printed, to three digits, rounded up."""
    with mpmath.workprec(64):
        rounding = abs(own(x)) * 5 * mpmath.mpf(10) ** -printed
        bound = (own(radius) + rounding) * (1 + mpmath.mpf(2) ** -7)
        return str(mpmath.nstr(bound, 3, strip_zeros=False))


def of_enclosure(found: Enclosure) -> JsonObject:
    """The object that ``reference --certified --json`` prints: proven digits alone.

    ``states``: decimals to which every number of the ball rounds; ``midpoints`` and ``radii``: the
    balls; ``error``: at each time the proven error of w over the largest |w|, or of gamma.
    """
    from polhode.numbers.balls import rounded_up

    scene = found.scene
    number = NumberType("mp", found.noise + 64)
    balls = found.decimals()
    answer: JsonObject = {
        "scene": scene.name,
        "number": "mp",
        "bits": number.bits,
        "digits": found.asked,
        "form": "principal",
        "regime": kind_of_body(scene.body),
        "reference": "certified",
        "proven": True,
        "columns": list(scene.columns),
        "times": [in_full(exactly(t)) for t in found.times],
        "states": found.strings(),
        "midpoints": [[middle for middle, _ in row] for row in balls],
        "radii": [[radius for _, radius in row] for row in balls],
        "error": rounded_up([10.0**-digits for digits in found.digits]),
        "digits_proven": [round(digits, 2) for digits in found.digits],
    }
    for name, part in (("angles", found.angles), ("attitude", found.attitude)):
        if part is not None:
            answer[name] = part.strings()
            answer[f"{name}_radii"] = [rounded_up(row) for row in part.radii]
            answer[f"{name}_digits_proven"] = [round(digits, 2) for digits in part.digits]
    for name, part in found.derived.items():
        answer[name] = of_column(name, answer["states"], part.strings())
        answer[f"{name}_radii"] = [rounded_up(row) for row in part.radii]
    return answer | {
        "outcome": found.outcome.value,
        "statement": list(found.statement),
        "assumed": list(found.assumed),
        **({"angles_lost": list(found.lost)} if found.lost else {}),
        **(
            {"omega_radius": [in_full(r) for r in found.omega_radius], "until": found.until}
            if found.omega_radius is not None
            else {}
        ),
        "steps": found.steps,
        "tries": found.tries,
        "seconds": round(found.seconds_in_all, 3),
        "provenance": scene.provenance(),
    }


def of_certified_events(found: CertifiedEvents) -> JsonObject:
    """Proven events: decimals to which every number of a time's ball rounds, radii, slopes, and
    the states then as midpoints and radii."""
    from polhode.numbers.balls import decimal_ball, guaranteed, rounded_up

    balls = [list(map(decimal_ball, t.state, t.radii)) for t in found.times]
    return {
        "name": found.name,
        "times": [guaranteed(t.time, t.radius) for t in found.times],
        "radii": rounded_up([t.radius for t in found.times]),
        "slopes": [t.slope for t in found.times],
        "states": [[middle for middle, _ in row] for row in balls],
        "state_radii": [[radius for _, radius in row] for row in balls],
        "undecided": [list(interval) for interval in found.undecided],
        "proven": found.proven,
    }


def held_times(scene: Scene, times: Sequence[Exact], digits: int) -> list[Exact]:
    """Times to be printed in full: decimals as they are, others rounded where no digit notices."""
    bits = number_types.bits_for(digits + 1)
    fine = NumberType("mp", 3 * bits + 64 + int(4 * scene.at(tuple(times)).log10_angle))
    return [t if is_decimal(t) else fine.rounded(t) for t in times]


def as_json(value: object) -> str:
    """JSON text, ASCII: a line for each key of an object and for each row of a table."""
    from json import dumps

    return _json(value, 0, partial(dumps, ensure_ascii=True, allow_nan=False)) + "\n"


def _json(value: object, depth: int, dumps: Callable[[object], str]) -> str:
    inner, outer = "\n" + " " * (depth + 1), "\n" + " " * depth
    if isinstance(value, dict) and value:
        lines = [f"{dumps(str(k))}: {_json(v, depth + 1, dumps)}" for k, v in value.items()]
        return "{" + inner + ("," + inner).join(lines) + outer + "}"
    if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
        lines = [_json(v, depth + 1, dumps) for v in value]
        return "[" + inner + ("," + inner).join(lines) + outer + "]"
    return dumps(value)


def frequencies(reference: Reference, digits: int = 17) -> dict[str, str | None]:
    """Period and frequencies of a reference as decimal strings."""
    number = NumberType("mp", number_types.bits_for(digits))
    found: dict[str, Real | None] = {"period": reference.period, **reference.frequencies}
    return {
        name: None if value is None else strings([[value]], number)[0][0]
        for name, value in found.items()
    }


def of_judgement(judged: Judgement) -> JsonObject:
    """The object that ``compare --json`` prints."""
    reference, subject = judged.reference, judged.subject
    parts, known = judged.part_digits, judged.agreement
    told = any(d is not None for digits in parts.values() for d in digits)
    answer: JsonObject = {
        "file": subject.name,
        "scene": reference.scene.name,
        "reference": reference.kind,
        "regime": reference.regime,
        "judged": [*subject.state, *judged.parts],
        "times": [in_full(t) for t in judged.times],
        "rows_judged": judged.rows_judged,
        "correct_digits": [
            None if d is None or is_lost(d, p) else round(d, 2)
            for d, p in zip(judged.digits, judged.expected, strict=True)
        ],
        "digits_expected": [
            None if b is None else [round(d, 2) for d in b] for b in judged.expected
        ],
        "digits_inputs": [None if d is None else round(d, 2) for d in judged.inputs],
        "amplification": [
            None if a is None or math.isinf(a) else float(f"{a:.4g}") for a in judged.amplification
        ],
        "worst": round(judged.worst, 2) if told and not judged.lost else None,
        "worst_time": in_full(judged.worst_time) if told else None,
        "worst_part": judged.worst_part if told else None,
        "limit": judged.limit or None,
        "chance": None if judged.chance is None else float(f"{judged.chance:.2g}"),
        "reading": judged.reading,
        "motion": None if judged.motion is None else of_motion(judged.motion),
        "yardstick": subject.number.name,
        "no_digits_left_after": judged.lost_after if judged.lost else None,
        "parts": {
            name: [None if d is None else round(d, 2) for d in digits]
            for name, digits in parts.items()
        },
        "right_until": {
            name: {"until": in_full(where.until), "since": in_full(where.since)}
            for name, where in judged.departures.items()
        },
        "drift": None if judged.drift is None else of_drift(judged.drift),
        "not_judged": list(judged.notes),
        "remarks": list(subject.remarks),
    }
    if judged.readings:
        answer["read_as"] = [
            {
                "part": r.part,
                "convention": r.convention,
                "digits": round(r.digits, 1),
                "rows": [{"t": in_full(t), "digits": round(d, 1)} for t, d in r.rows],
            }
            for r in judged.readings
        ]
    if judged.causes:
        answer["causes"] = [
            {"cause": cause.words, "digits": round(cause.digits, 1)} for cause in judged.causes
        ]
    answer["proven"] = reference.proven
    if not reference.is_closed_form:
        answer["reference_digits"] = None if math.isnan(known) else round(known, 1)
    return answer


def of_order(found: ObservedOrder) -> JsonObject:
    """The object that ``compare --orders --json`` prints."""
    return {
        "files": [*found.names],
        "steps": [*found.steps],
        "times": [in_full(t) for t in found.times],
        "correct_digits": [[round(d, 2) for d in row] for row in found.digits],
        "orders": [None if x is None else round(x, 3) for x in found.orders],
        "order": round(found.order, 3),
        "least": round(found.least, 3),
        "most": round(found.most, 3),
    }


def of_motion(found: Lyapunov) -> JsonObject:
    """The verdict regular or chaotic as a JSON object."""
    return {
        "verdict": found.verdict,
        "exponent": float(f"{found.exponent:.4g}"),
        "uncertainty": None if found.uncertainty == math.inf else float(f"{found.uncertainty:.2g}"),
        "until": found.end,
        "reason": found.reason,
    }
