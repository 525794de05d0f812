"""What verbs say on stderr about their results, beside them."""

from __future__ import annotations

import math
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import counted
from polhode.common.files import is_stdout
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.decimals import brief, guaranteed

if TYPE_CHECKING:
    from polhode.dynamics.chaos_map import ChaosMap
    from polhode.dynamics.frequencies import Frequencies
    from polhode.dynamics.orbit import Orbit
    from polhode.dynamics.section import Section
    from polhode.enclosures.result import CertifiedEvents, Enclosure
    from polhode.motion.outcomes import EventTimes
    from polhode.proofs.proved_chaos import ProvedChaos
    from polhode.proofs.proved_orbit import ProvedOrbit
    from polhode.proofs.proved_stability import ProvedStability
    from polhode.runs.trajectory import Trajectory
    from polhode.verbs.catalogue import Verb

_ROUNDED = 1e-14  # of the step between samples: more is told

#: A result of any kind: each function knows that of its verb.
AnyResult = Any


def of(
    verb: Verb, result: AnyResult, written: Sequence[Path], namespace: Namespace
) -> Iterator[str]:
    """The lines about a result of a verb, and what was ``written`` of it."""
    yield from globals()[verb.notes](result, namespace)
    proofs: list[Path] = []
    if ".json" in verb.own:
        places = [x for x in map(Path, namespace.places or ()) if x in written]
        proofs = [x for x in places if x.suffix.lower() == ".json" or is_stdout(x)][:1]
    if files := [str(x) for x in written if x not in proofs and not is_stdout(x)]:
        yield f"written: {', '.join(files)}"
    yield from (_certificate(result.scene.name, x) for x in proofs)


def name_of(result: AnyResult) -> str:
    """The name of what a result is of."""
    return str(result.name if hasattr(result, "name") else result.fact("scene"))


def itself(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """What a result says of itself."""
    yield f"{name_of(result)}: {result!r}"


def _certificate(name: str, path: Path) -> str:
    if is_stdout(path):
        return f"{name}: certificate on the standard output; polhode verify - reads it"
    return f"{name}: certificate in {path}; polhode verify {path}"


def run(result: Trajectory, namespace: Namespace) -> Iterator[str]:
    """Number type, accuracy and events of a run, and what its digits are worth."""
    name, number = result.scene.name, result.number
    if not namespace.json:
        yield (
            f"{name}: {number.name} ({number.bits} bits); {result.outcome.value}, "
            f"{counted(result.steps, 'step')}; {_accuracy(result)}"
        )
        if "not refined" in result.provenance:
            yield f"{name}: not refined: {result.provenance['not refined']}"
        yield from map(_event, result.events)
    yield from _digits(result)
    if not result.complete:
        advice = f"; {result.advice}" if result.advice else ""
        yield (
            f"polhode: {name}: reached t = {brief(result.reached)} of {brief(result.scene.end)}: "
            f"{result.cause}{advice}"
        )


def _accuracy(result: Trajectory) -> str:
    """What a run itself tells about its accuracy."""
    if result.errors is not None:
        pairs = zip(result.errors, result.times, strict=True)
        estimates = [(x, t) for x, t in pairs if x is not None]
        if not any(t for _, t in estimates):
            return "refined, without an estimate of the error"
        last = brief(max((t for _, t in estimates), key=abs))
        is_lost = len(estimates) < len(result.errors)
        lost = f" to t = {last}, no estimate beyond it" * is_lost
        return f"refined, estimated error {max(x for x, _ in estimates):.1e}{lost}"
    if result.projected:
        return f"projected {result.projection}"
    return f"drift {result.drift}" if len(result.times) else "no output time was reached"


def _event(event: EventTimes) -> str:
    """One line about an event: how often, and when first."""
    marks = [" (grazing)" * grazing for grazing in event.grazing[:10]]
    times = [event.shown(k) + mark for k, mark in enumerate(marks)]
    more = ", ..." * (len(event.times) > len(times))
    when = f" at t = {', '.join(times)}{more}" if times else ""
    lost = "" if event.complete else "; a zero was lost, or a pole passed"
    return f"event {event.name}: {len(event.times)}{when}{lost}"


def _digits(result: Trajectory) -> Iterator[str]:
    """What the digits printed are worth: those that are right, or where the motion takes most."""
    name, right = result.scene.name, result.correct_digits
    if right is not None:
        had = f"{math.floor(100 * right) / 100} are right by the {result.checked_by}"
        yield f"{name}: {result.digits} digits were asked for, {had}"
        return
    expected = result.expected
    if expected.halved_after is None:
        return
    printed, lost = result.number.printed_digits, expected.lost_after
    none = "" if lost is None else f", and none from t = {lost:.3g} on"
    yield (
        f"polhode: {name}: from t = {expected.halved_after:.3g} on fewer than half of the "
        f"{printed} printed digits are expected to be correct{none}: this motion multiplies "
        f"errors; --digits D gives D correct ones"
    )


def sweep(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """Members, number type, and how members ended."""
    if not namespace.json:
        outputs = getattr(
            result, "outputs", result.scene.outputs
        )  # of numbers alone there are none
        words = [word for word in result.scene.outputs if word not in outputs]
        left_out = f"; {', '.join(words)} left out" if words else ""
        unchecked = ""
        if getattr(namespace, "digits", None) is not None:
            unchecked = f"; number type chosen for {namespace.digits} digits, members not checked"
        ended = ", ".join(f"{n} {outcome.value}" for outcome, n in result.tally().items())
        yield (
            f"{result.scene.name}: {counted(len(result), 'member')}, {result.number.name} "
            f"({result.number.bits} bits), not projected{left_out}{unchecked}; {ended}"
        )
    for outcome in result.tally():
        if not outcome.done:
            advice = f"; {outcome.advice}" if outcome.advice else ""
            first = result.endings.tolist().index(code(outcome))
            yield f"polhode: {result.members[first].name}: {outcome.cause}{advice}"


def section(result: Section, namespace: Namespace) -> Iterator[str]:
    """How orbits ended, and where no digit is left."""
    counts = Counter(result.outcomes)
    ended = ", ".join(f"{outcome} in {n}" for outcome, n in counts.items())
    yield f"{result.scene.name}: {result!r}; {ended}"
    if result.accuracy and not result.interrupted:
        yield f"{result.scene.name}: {_lost(result)}"


def _lost(result: Section) -> str:
    """In how many orbits no digit is left at the end, and from which crossing on."""
    first = result.none_left_from
    if not result.counts.any():
        return "no crossing"
    if not first.any():
        import numpy as np

        least = float(np.nanmin(result.digits))
        return f"{least:.1f} digits or more are expected at every crossing"
    gone = sorted(first[first > 0].tolist())
    where = f"{gone[0]}" if gone[0] == gone[-1] else f"{gone[0]} to {gone[-1]}"
    return f"no digits are left from crossing {where} on in {len(gone)} of {len(first)} orbits"


def chaos_map(result: ChaosMap, namespace: Namespace) -> Iterator[str]:
    """How many motions there are, and what their verdicts rest on."""
    yield f"{result.scene.name}: {counted(len(result.verdict), 'motion')}, {result.meaning}"


def orbit(result: Orbit, namespace: Namespace) -> Iterator[str]:
    """What an orbit may be off."""
    yield (
        f"{result.name}: start and period right to {result.error:.1e}, residue to "
        f"{result.residue_error:.1e}, |det M - 1| = {result.determinant:.1e}; "
        f"{result.moved:.2g} from the guess"
    )


def reference(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """What is left out, and whether the digits are proven."""
    if vars(namespace).get("backend") == "mpmath" and vars(namespace).get("outputs") is None:
        without = ", ".join(namespace.scene.outputs)
        if without:
            yield f"{result.scene.name}: without {without}: mpmath has states alone"
    if not result.proven:
        yield f"{result.scene.name}: the digits are reproduced, not proven"


def certified(result: Enclosure, namespace: Namespace) -> Iterator[str]:
    """Proven digits and events, and what ended the proof."""
    name, outcome = result.scene.name, result.outcome
    if not namespace.json:
        yield from map(_proven_event, result.events or ())
        least = (
            f"at least {result.fewest:.1f} at each time" if result.times else "no time was reached"
        )
        yield (
            f"{name}: every digit is proven, {least}; {counted(result.steps, 'step')} at a "
            f"noise level of 2**-{result.noise}, {result.seconds_in_all:.1f} s"
        )
    for assumption in result.assumed:
        yield f"{name}: assumed by the rule for equal numbers, not proven: {assumption}"
    for since in result.lost:
        yield (
            f"{name}: psi and phi are not given beyond t = {since:.6g}: the third axis is, "
            "or passes, too near the vertical for their turns to be counted"
        )
    if not outcome.done:
        followed = f"followed to t = {result.until:.6g}: " if outcome is Outcome.TOO_WIDE else ""
        times = f"{len(result.times)} of {len(result.scene.times)} times"
        yield f"polhode: {name}: {times}: {followed}{outcome.cause}; {outcome.advice}"


def _proven_event(event: CertifiedEvents) -> str:
    """One line about proven events: how many, and the first of them."""
    shown = [guaranteed(t.time, t.radius) for t in event.times[:10]]
    more = ", ..." * (len(event.times) > len(shown))
    when = f" at t = {', '.join(shown)}{more}" if shown else ""
    left = ", no others"
    if event.undecided:
        open_ = [f"{low:.6g} to {high:.6g}" for low, high in event.undecided[:3]]
        left = f"; undecided from {', '.join(open_)}" + ", ..." * (len(event.undecided) > 3)
    return f"event {event.name}: {len(event.times)} proven{when}{left}"


def check(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """What is missing where nothing was checked."""
    if result.passed is None and not result.interrupted:
        yield (
            "polhode check: expected a case with bands of digits ([expect]), which --propose "
            "prints, or with figures"
        )


def nothing(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """No line: all is said on stdout."""
    yield from ()


def orbits(result: AnyResult, namespace: Namespace) -> Iterator[str]:
    """What a search found."""
    yield f"{result.scene.name}: {result!r}; no list is complete"


def frequencies(result: Frequencies, namespace: Namespace) -> Iterator[str]:
    """Signals without lines, rounded times, known rates."""
    for signal, lines in result.lines.items():
        if not lines:
            yield f"{result.name}: {signal} has no line above rounding"
    if result.step_error > _ROUNDED * abs(result.step):
        yield (
            f"{result.name}: the times are rounded: spacing {result.step:.12g} ± "
            f"{result.step_error:.1g} fits them all, and the errors include it"
        )
    kind = "closed form" if result.closed_form else "basis"
    words = {name: f" {words}" for name, words in result.rates_of.items()}
    rates = [f"{name}{words.get(name, '')} = {x:.15g}" for name, x in result.known.items()]
    if rates:
        yield f"{result.name}: {kind}: {', '.join(rates)}"


def proved_orbit(result: ProvedOrbit | ProvedStability, namespace: Namespace) -> Iterator[str]:
    """What a proof of an orbit took, and what it trusts."""
    from polhode.certificates.verdict import trusted_base

    yield (
        f"{result.scene.name}: every digit is proven; {counted(result.runs, 'run')} of the checker "
        f"at {result.bits} bits, {result.seconds:.2f} s"
    )
    yield trusted_base()


def proved_chaos(result: ProvedChaos, namespace: Namespace) -> Iterator[str]:
    """What a proof of chaos took, and what it trusts."""
    from polhode.certificates.verdict import trusted_base

    yield f"{result.scene.name}: proved at try {result.tries}, {result.seconds:.2f} s"
    yield trusted_base()
