"""The verbs of the command line: each takes the parsed options and returns an exit code."""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode import answers, expression, library, precision
from polhode.errors import BadInput
from polhode.exact import Exact
from polhode.expression import ExpressionError
from polhode.precision import shown
from polhode.provenance import cpu, versions
from polhode.scene import Scene

if TYPE_CHECKING:
    from polhode.trajectory import EventTimes

DONE, FAILED, BAD_INPUT, NOT_REACHED, INTERRUPTED = 0, 1, 2, 3, 130


def list(options: Namespace) -> int:  # the verb's name
    """The cases that ship."""
    from polhode.truth import reference

    rows = []
    for name in library.names():
        scene = library.load(name)
        if options.tag and options.tag not in scene.tags:
            continue
        truth = reference(scene)
        rows.append(
            {
                "name": name,
                "title": scene.title,
                "tags": [*scene.tags],
                "regime": truth.regime,
                "reference": truth.kind,
            }
        )
    if options.json:
        _print_json(rows)
    else:
        table = [[r["name"], r["reference"], r["regime"], r["title"]] for r in rows]
        _print_table(["case", "reference", "regime", "title"], table)
    return DONE


def show(options: Namespace) -> int:
    """Body, regime, integrals, frequencies, what will be modelled."""
    from polhode.show import described

    facts = described(library.load(options.scene))
    if options.json:
        _print_json(facts)
        return DONE
    for key, value in facts.items():
        if isinstance(value, dict):
            value = ", ".join(f"{k} = {v}" for k, v in value.items() if v is not None)
        elif isinstance(value, (tuple, [].__class__)):
            value = ", ".join(str(x) for x in value)
        if value not in (None, ""):
            print(f"{key:<14}{value}")
    return DONE


def run(options: Namespace) -> int:
    """Integrate a scene."""
    from dataclasses import replace

    from polhode.integration import integrate
    from polhode.trajectory import Outcome
    from polhode.truth import reference

    scene = library.load(options.scene)
    if options.at is not None:
        scene = scene.at(_times(scene, options.at))
    if options.form is not None:
        scene = replace(scene, form=options.form)
    if options.outputs is not None:
        scene = replace(scene, outputs=tuple(o for o in options.outputs.split(",") if o))
    path = None if options.file is None else Path(options.file)
    if path is not None:
        answers.check_paths(path)
    truth = reference(scene)
    with _Progress("run") as progress:
        found = integrate(
            scene,
            options.number,
            digits=options.digits,
            tol=options.tol,
            max_steps=options.max_steps,
            progress=progress.show,
        )
    answer = answers.of_run(found, truth.regime)
    done = found.outcome.done
    if done and options.digits is not None and truth.is_closed_form:
        answer["correct_digits"] = _judged(found, truth)
    if path is not None and done:
        answers.write_trajectory(path, answer)
    if options.json:
        _print_json(answer)
    elif path is None:
        _print_rows(answer)
    if not options.json:
        _note(
            f"{scene.name}: {answer['number']} ({answer['bits']} bits), {answer['regime']}; "
            f"{answer['outcome']}, {answer['steps']} steps; drift "
            + ", ".join(f"{k} {v}" for k, v in answer["drift"].items() if v is not None)
        )
        for event in found.events:
            _note(_told(event))
    if done:
        _warn_of_lost_digits(scene, options.digits, answer)
        return DONE
    advice = f"; {found.outcome.advice}" if found.outcome.advice else ""
    wrote = "" if path is None else f"; {path} was not written"
    _note(
        f"polhode: {scene.name}: reached t = {float(found.reached):g} of {float(scene.end):g}: "
        f"{found.outcome.cause}{advice}{wrote}"
    )
    return INTERRUPTED if found.outcome is Outcome.INTERRUPTED else NOT_REACHED


def reference(options: Namespace) -> int:
    """The closed form alone."""
    from polhode.truth import Reference
    from polhode.truth import reference as truth_of

    scene = library.load(options.scene)
    times = scene.times if options.at is None else _times(scene, options.at)
    if not times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    if not 1 <= options.digits <= precision.MAX_DIGITS:
        expected = f"1 to {precision.MAX_DIGITS}"
        raise BadInput(scene.name, "digits", options.digits, expected)
    truth = truth_of(scene)
    if not isinstance(truth, Reference):
        raise BadInput(scene.name, "reference", truth.regime, "a scene with a closed form")
    answer = answers.of_reference(truth, times, options.digits)
    if options.json:
        _print_json(answer)
    else:
        _print_rows(answer)
    return DONE


def check(options: Namespace) -> int:
    """The library's regression."""
    from polhode.studies.regression import check as checks

    reports = []
    with _Progress("check") as progress:
        for report in checks(options.scenes, options.number or (), progress.say):
            reports.append(report)
            if not options.json:
                progress.clear()
                _print_check(report)
    passed = all(report.passed for report in reports)
    if options.json:
        _print_json({"passed": passed, "cases": [answers.of_check(r) for r in reports]})
    else:
        bad = sum(not r.passed for r in reports)
        print(f"{len(reports) - bad} passed, {bad} failed")
    return DONE if passed else FAILED


def compare(options: Namespace) -> int:
    """Judge a trajectory that some other program computed."""
    from polhode import foreign
    from polhode.integration import choose_number
    from polhode.judging import few
    from polhode.truth import reference as truth_of

    scene = library.load(options.scene)
    number = None
    if options.number is not None:
        number = choose_number(scene, options.number, options.digits)
    table = foreign.read_table(Path(options.file), number)
    verdict = foreign.judge(table, truth_of(scene), number)
    answer = answers.of_verdict(verdict)
    if options.json:
        _print_json(answer)
        return DONE
    truth = verdict.reference
    print(f"{table.name} against {truth.kind} of {scene.name} ({truth.regime})")
    if verdict.digits:
        shown_rows = few(len(verdict.digits), 11)
        rows = [[answer["times"][k], f"{answer['correct_digits'][k]:.2f}"] for k in shown_rows]
        _print_table(["t", "correct digits"], rows)
        if len(rows) < len(verdict.digits):
            print(f"({len(rows)} of {len(verdict.digits)} times; all of them with --json)")
        assert verdict.worst_time is not None
        print(f"worst {verdict.worst:.2f} correct digits at t = {float(verdict.worst_time):g}")
    for name, digits in verdict.parts.items():
        print(f"{name}: {digits:.2f} correct digits")
    if answer["drift"] is not None:
        print("drift " + ", ".join(f"{k} {v}" for k, v in answer["drift"].items() if v))
    for note in verdict.notes:
        print(f"not judged: {note}")
    return DONE


def report(options: Namespace) -> int:
    """Run the studies and write them."""
    from polhode.report import write_report

    folder = Path(options.folder)
    with _Progress("report") as progress:
        written = write_report(folder, quick=options.quick, tick=progress.say)
    if options.json:
        _print_json({"written": [str(path) for path in written]})
    else:
        print("\n".join(str(path) for path in written))
    return DONE


def about(options: Namespace) -> int:
    """Versions, number types, processor, caches."""
    from polhode import taylor

    facts: dict[str, Any] = {
        "versions": versions(),
        "cpu": cpu(),
        "number_types": {
            n.name: {"bits": n.bits, "digits": round(n.most_digits, 1)}
            for n in (precision.named(name) for name in precision.NAMES)
        },
        "cases": len(library.names()),
        "cache": taylor.cache(),
    }
    if options.json:
        _print_json(facts)
        return DONE
    for name, version in facts["versions"].items():
        print(f"{name:<10}{version}")
    print(f"{'cpu':<10}{facts['cpu']}")
    for name, held in facts["number_types"].items():
        size = "any number of bits" if name == "mp" else f"{held['bits']} bits"
        print(f"{name:<10}{size}" + ("" if name == "mp" else f", {held['digits']} digits"))
    cache = facts["cache"]
    print(f"{'cases':<10}{facts['cases']}")
    state = f"{cache['bytes']} bytes in {cache['path']}" if cache["enabled"] else "off"
    print(f"{'cache':<10}{state}")
    return DONE


def _judged(found: Any, truth: Any) -> float:
    """The fewest correct digits over a few of a run's times, by the closed form."""
    from dataclasses import replace

    from polhode.judging import compare, few

    kept = few(len(found.times), 20)
    part = replace(
        found,
        times=tuple(found.times[k] for k in kept),
        states=[found.states[k] for k in kept],
    )
    return round(compare(part, truth).worst, 2)


def _told(event: EventTimes) -> str:
    """One line about an event: how often, and when first."""
    shown_times = [
        f"{float(t):.17g}" + " (grazing)" * grazing
        for t, grazing in zip(event.times[:10], event.grazing, strict=False)
    ]
    more = ", ..." * (len(event.times) > len(shown_times))
    when = f" at t = {', '.join(shown_times)}{more}" if shown_times else ""
    lost = "" if event.complete else "; a zero was lost, or a pole passed"
    return f"event {event.name}: {len(event.times)}{when}{lost}"


def _warn_of_lost_digits(scene: Scene, wanted: int | None, answer: dict[str, Any]) -> None:
    """Say so where a run has fewer digits than were asked for: the motion multiplies errors."""
    held = answer.get("correct_digits")
    if wanted is not None and held is not None and held < wanted:
        _note(
            f"polhode: {scene.name}: {wanted} digits were asked for, {held} are correct by the "
            f"closed form: this motion multiplies errors; ask for {2 * wanted - int(held) + 1}"
        )


def _times(scene: Scene, text: str) -> tuple[Exact, ...]:
    times = []
    for item in text.split(","):
        try:
            times.append(expression.number(item))
        except ExpressionError as fault:
            raise BadInput(scene.name, "--at", item, f"a time ({fault})") from None
    return tuple(times)


def _print_json(value: Any) -> None:
    sys.stdout.write(answers.as_json(value))


def _print_rows(answer: dict[str, Any]) -> None:
    header, rows = answers.rows_of(answer)
    _print_table(header, rows)


def _print_table(header: Any, rows: Any) -> None:
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    for row in (header, *rows):
        print("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip())


def _print_check(report: Any) -> None:
    mark = "ok  " if report.passed else "FAIL"
    print(f"{mark} {report.scene.name} ({report.regime}, {report.reference})")
    for line in report.lines:
        band = "" if line.band is None else f" in [{line.band[0]:g}, {line.band[1]:g}]"
        print(f"     {line.number:<9}{line.digits:6.2f} digits{band}: {line.verdict}")
    for figure in report.figures:
        p = figure.published
        print(f"     {p.quantity} at t = {shown(p.t)}: {figure.verdict}  ({p.cite})")
        print(f"         printed {p.value}")
        print(f"         ours    {figure.ours}")


def _note(text: str) -> None:
    print(text, file=sys.stderr)


class _Progress:
    """One line on stderr, on a terminal only, once something takes longer than a second."""

    def __init__(self, verb: str) -> None:
        self.verb, self.shown = verb, False
        self.began = time.monotonic()

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()

    def show(self, fraction: float, steps: int) -> None:
        self.say(f"{100 * fraction:.1f} %, {steps} steps")

    def say(self, text: str) -> None:
        if sys.stderr.isatty() and time.monotonic() - self.began > 1:
            sys.stderr.write(f"\r\x1b[K{self.verb}: {text}")
            sys.stderr.flush()
            self.shown = True

    def clear(self) -> None:
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
            self.shown = False
