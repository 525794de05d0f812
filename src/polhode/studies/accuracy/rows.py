"""Study ``accuracy``: correct digits of every case in every number type, and of what others print.

The closed forms that cases are judged by are held against proven enclosures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from polhode.checks.textbook_digits import textbook_digits
from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.common.provenance import digest
from polhode.common.texts import JsonObject
from polhode.judging.adaptive_precision import integrate
from polhode.judging.compare import judgement
from polhode.judging.conditioning import Band, Conditioning, conditioning
from polhode.judging.correct_digits import worst_digits
from polhode.judging.judgement import Judgement
from polhode.judging.reference import AnyReference
from polhode.judging.reference import reference as reference_of
from polhode.judging.score import score
from polhode.judging.tables.table import of_run
from polhode.numbers import conversion, decimals, number_types
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies.accuracy.printed import printed_figures
from polhode.studies.accuracy.proven import provable, proven_case
from polhode.studies.row_filter import Only

QUESTION = (
    "How many digits of each case's trajectory are correct in each number type, how far do the "
    "integrals drift, and what does rounding the inputs alone cost? Does every closed form lie in "
    "its proven enclosure, and how many digits of figures that others printed are right?"
)
QUICK_CASES = (
    *("euler/largest-axis", "euler/separatrix", "euler/sphere", "euler/turned-axes"),
    *("general/asymmetric-chaotic", "published/nasa-brick"),
)
#: Longest integration, as the angle |w|·|end|, that each number type is given in the study.
LONGEST = {"double": 1e7, "extended": 1e6, "quad": 1e4, "mp": 3e3}
#: Rows that this process made: the study of stability takes those of the hard cases up again.
_made: dict[str, dict[str, Any]] = {}


def rows(quick: bool, say: Message, wanted: Only) -> JsonObject:
    """The study's rows; no figure in them depends on the clock."""
    every = [library.load(name) for name in (QUICK_CASES if quick else library.names())]
    workers = 1 if quick else cores()

    def begun(scene: Scene) -> None:
        say(scene.name)

    cases = case_rows([scene for scene in every if wanted(scene.name)], workers, begun)
    asked = [scene for scene in every if wanted(scene.name, "proven")]
    alone = [scene for scene in map(provable, asked) if scene is not None]
    printed, labels = [], []
    for scene in every:
        if scene.published and wanted(scene.name, "printed"):
            begun(scene)
            figures, moved = printed_figures(scene)
            printed += figures
            labels += moved
    return {
        "cases": cases,
        "proven": [*in_order(proven_case, alone, workers, begun)],
        "printed": printed,
        "time_labels": labels,
    }


def case_rows(
    scenes: Sequence[Scene], workers: int, begun: Callable[[Scene], None] | None = None
) -> list[dict[str, Any]]:
    """One row per case of the library, made once in a process; the longest motions come first."""
    asked = [scene for scene in scenes if scene.name not in _made]
    asked.sort(key=lambda scene: -scene.log10_angle)
    for row in in_order(_case, asked, workers, begun):
        _made[row["case"]] = row
    return [_made[scene.name] for scene in scenes]


def _case(scene: Scene) -> dict[str, Any]:
    reference = reference_of(scene)
    fitting = [name for name in number_types.NAMES if 10**scene.log10_angle <= LONGEST[name]]
    known = conditioning(scene, number=number_types.named(fitting[-1])) if fitting else None
    runs = [_run(scene, reference, name, known) for name in reversed(fitting)]  # most digits first
    kappas = [x for x in known.log10_kappa if x is not None] if known else []
    return {
        "case": scene.name,
        "title": scene.title,
        "regime": reference.regime,
        "reference": reference.kind,
        "textbook": rounded(textbook_digits(reference)),
        "log10_kappa": round(max(kappas), 2) if kappas else None,
        "kappa_note": known.note if known else "",
        "end": decimals.decimal_string(conversion.exactly(number_types.QUAD.rounded(scene.end)), 6),
        "sha256": digest(scene.text),
        "runs": runs[::-1],
    }


def _run(
    scene: Scene, reference: AnyReference, name: str, known: Conditioning | None
) -> dict[str, Any]:
    run = integrate(
        scene,
        name,
        digits=number_types.DEFAULT_MP_DIGITS if name == "mp" else None,
        method="taylor",
    )
    found: dict[str, Any] = {
        "number": name,
        "bits": run.number.bits,
        "outcome": run.outcome.value,
        "steps": run.steps,
    }
    if run.outcome.done:
        judged = judgement(score(of_run(run), reference), details=True, known=known)
        worst = judged.state_worst
        at = judged.digits.index(worst)
        found |= {
            "correct_digits": round(worst, 2),
            "worst_time": float(judged.times[at]),
            "times": len(judged.times),
            "inputs": rounded(judged.inputs[at]),
            "expected": band(judged.expected[at]),
            "limit": judged.limit,
            "lost": judged.lost or None,
            "drift": {
                key: None if value is None else float(f"{value:.2e}")
                for key, value in run.drift._asdict().items()
            },
            "projection": projection(run),
            "refined": _refined(run, judged) if name == "quad" else None,
            "reference_digits": None if reference.is_closed_form else round(reference.agreement, 1),
        }
    return found


def _refined(steps: Trajectory, judged: Judgement) -> dict[str, Any] | None:
    """The run made again by refinement, where that can be done: a method of its own.

    ``agreement``: the digits to which both runs' states are the same.
    """
    scene = replace(steps.scene, outputs=(), events=())
    run = integrate(scene, steps.number)
    if run.method != "refined" or not run.outcome.done:
        return None
    held = steps.number.most_digits
    return {
        "correct_digits": round(
            score(of_run(run), judged.reference, earlier=judged).state_worst, 2
        ),
        "agreement": round(worst_digits(run.states, steps.states, scene, held), 2),
    }


def rounded(digits: float | None) -> float | None:
    """Digits as they are printed."""
    return None if digits is None else round(digits, 2)


def band(expected: Band | None) -> list[float] | None:
    """The least, the middle and the most digits expected."""
    return None if expected is None else [round(digits, 2) for digits in expected]


def projection(run: Trajectory) -> dict[str, Any] | None:
    """The corrections of a run that was put back on its integrals; None where it was not."""
    if run.projection is None:
        return None
    return {
        "onto": [*run.projection.onto],
        "count": run.projection.count,
        "largest": float(f"{run.projection.largest:.2e}"),
        "sum": float(f"{run.projection.sum:.2e}"),
    }
