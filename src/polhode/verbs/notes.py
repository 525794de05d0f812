"""What verbs say on stderr about their results, beside them."""

from __future__ import annotations

import math
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.files import is_stdout
from polhode.common.text_tables import counted
from polhode.motion.outcomes import Outcome
from polhode.numbers.balls import guaranteed
from polhode.numbers.decimals import brief
from polhode.scenes import library

if TYPE_CHECKING:
    from polhode.dynamics.chaos.chaos_map import ChaosMap
    from polhode.dynamics.frequencies.frequencies import Frequencies
    from polhode.dynamics.periodic_orbits.orbit import Orbit
    from polhode.dynamics.sections.section import Section
    from polhode.enclosures.certified_events import CertifiedEvents
    from polhode.enclosures.result import Enclosure
    from polhode.motion.outcomes import EventTimes
    from polhode.proofs.chaos.proved_chaos import ProvedChaos
    from polhode.proofs.proved_orbit import ProvedOrbit
    from polhode.runs.trajectory import Trajectory

#: A result of any kind: each function knows that of its verb.
Found = Any


def of(verb: str, found: Found, paths: Sequence[Path], asked: Namespace) -> Iterator[str]:
    """The lines about a result of a verb."""
    yield from _NOTES.get(verb, _itself)(found, asked)
    own = [x for x in paths if x.suffix.lower() == ".json" or is_stdout(x)]
    if verb in ("certify", "prove orbit", "prove chaos") and own and getattr(found, "times", True):
        yield _certificate(found.scene.name, own[0])


def name_of(found: Found) -> str:
    """The name of what a result is of."""
    return str(found.name if hasattr(found, "name") else found.fact("scene"))


def _itself(found: Found, asked: Namespace) -> Iterator[str]:
    yield f"{name_of(found)}: {found!r}"


def _certificate(name: str, path: Path) -> str:
    if is_stdout(path):
        return f"{name}: certificate on the standard output; polhode verify - reads it"
    return f"{name}: certificate in {path}; polhode verify {path}"


def _run(found: Trajectory, asked: Namespace) -> Iterator[str]:
    name, number = found.scene.name, found.number
    if not asked.json:
        yield (
            f"{name}: {number.name} ({number.bits} bits); {found.outcome.value}, "
            f"{counted(found.steps, 'step')}; {_accuracy(found)}"
        )
        if "not refined" in found.provenance:
            yield f"{name}: not refined: {found.provenance['not refined']}"
        yield from map(_event, found.events)
    yield from _digits(found)
    if not found.complete:
        advice = f"; {found.advice}" if found.advice else ""
        yield (
            f"polhode: {name}: reached t = {brief(found.reached)} of {brief(found.scene.end)}: "
            f"{found.cause}{advice}"
        )


def _accuracy(found: Trajectory) -> str:
    """What a run itself tells about its accuracy."""
    if found.errors is not None:
        known = [(x, t) for x, t in zip(found.errors, found.times, strict=True) if x is not None]
        if not any(t for _, t in known):
            return "refined, without an estimate of the error"
        last = brief(max((t for _, t in known), key=abs))
        lost = "" if len(known) == len(found.errors) else f" to t = {last}, no estimate beyond it"
        return f"refined, estimated error {max(x for x, _ in known):.1e}{lost}"
    if found.projected:
        return f"projected {found.projection}"
    return f"drift {found.drift}" if len(found.times) else "no output time was reached"


def _event(event: EventTimes) -> str:
    """One line about an event: how often, and when first."""
    times = [
        event.shown(k) + " (grazing)" * grazing for k, grazing in enumerate(event.grazing[:10])
    ]
    more = ", ..." * (len(event.times) > len(times))
    when = f" at t = {', '.join(times)}{more}" if times else ""
    lost = "" if event.complete else "; a zero was lost, or a pole passed"
    return f"event {event.name}: {len(event.times)}{when}{lost}"


def _digits(found: Trajectory) -> Iterator[str]:
    """What the digits printed are worth: those found right, or where the motion takes most."""
    name, right = found.scene.name, found.correct_digits
    if right is not None:
        had = f"{math.floor(100 * right) / 100} are right by the {found.checked_by}"
        yield f"{name}: {found.digits} digits were asked for, {had}"
        return
    expected = found.expected
    if expected.halved_after is None:
        return
    printed, lost = found.number.printed_digits, expected.lost_after
    none = "" if lost is None else f", and none from t = {lost:.3g} on"
    yield (
        f"polhode: {name}: from t = {expected.halved_after:.3g} on fewer than half of the "
        f"{printed} printed digits are expected to be correct{none}: this motion multiplies "
        f"errors; --digits D gives D correct ones"
    )


def _sweep(found: Found, asked: Namespace) -> Iterator[str]:
    from polhode.motion.outcomes import code

    if not asked.json:
        made = getattr(found, "outputs", found.scene.outputs)  # of numbers alone there are none
        words = [word for word in found.scene.outputs if word not in made]
        left_out = f"; {', '.join(words)} left out" if words else ""
        unchecked = ""
        if getattr(asked, "digits", None) is not None:
            unchecked = f"; number type chosen for {asked.digits} digits, members not checked"
        ended = ", ".join(f"{n} {outcome.value}" for outcome, n in found.tally().items())
        yield (
            f"{found.scene.name}: {counted(len(found), 'member')}, {found.number.name} "
            f"({found.number.bits} bits), not projected{left_out}{unchecked}; {ended}"
        )
    for outcome in found.tally():
        if not outcome.done:
            advice = f"; {outcome.advice}" if outcome.advice else ""
            first = found.endings.tolist().index(code(outcome))
            yield f"polhode: {found.members[first].name}: {outcome.cause}{advice}"


def _section(found: Section, asked: Namespace) -> Iterator[str]:
    told = Counter(found.outcomes)
    ended = ", ".join(f"{outcome} in {n}" for outcome, n in told.items())
    yield f"{found.scene.name}: {found!r}; {ended}"
    if found.accuracy and not found.interrupted:
        yield f"{found.scene.name}: {_lost(found)}"


def _lost(found: Section) -> str:
    """In how many orbits no digit is left at the end, and from which crossing on."""
    first = found.none_left_from
    if not found.counts.any():
        return "no crossing"
    if not first.any():
        import numpy as np

        least = float(np.nanmin(found.digits))
        return f"{least:.1f} digits or more are expected at every crossing"
    gone = sorted(first[first > 0].tolist())
    where = f"{gone[0]}" if gone[0] == gone[-1] else f"{gone[0]} to {gone[-1]}"
    return f"no digits are left from crossing {where} on in {len(gone)} of {len(first)} orbits"


def _map(found: ChaosMap, asked: Namespace) -> Iterator[str]:
    yield f"{found.scene.name}: {counted(len(found.verdict), 'motion')}, {found.meaning}"


def _orbit(found: Orbit, asked: Namespace) -> Iterator[str]:
    yield (
        f"{found.name}: start and period right to {found.error:.1e}, residue to "
        f"{found.residue_error:.1e}, |det M - 1| = {found.determinant:.1e}; "
        f"{found.moved:.2g} from the guess"
    )


def _reference(found: Found, asked: Namespace) -> Iterator[str]:
    if vars(asked).get("backend") == "mpmath" and vars(asked).get("outputs") is None:
        without = ", ".join(library.load(asked.scene).outputs)
        if without:
            yield f"{found.scene.name}: without {without}: mpmath has states alone"
    if not found.proven:
        yield f"{found.scene.name}: the digits are reproduced, not proven"


def _certify(found: Enclosure, asked: Namespace) -> Iterator[str]:
    name, outcome = found.scene.name, found.outcome
    if not asked.json:
        yield from map(_proven_event, found.events or ())
        least = (
            f"at least {found.fewest:.1f} at each time" if found.times else "no time was reached"
        )
        yield (
            f"{name}: every digit is proven, {least}; {counted(found.steps, 'step')} at a "
            f"noise level of 2**-{found.noise}, {found.seconds_in_all:.1f} s"
        )
    for what in found.assumed:
        yield f"{name}: assumed by the rule for equal numbers, not proven: {what}"
    for since in found.lost:
        yield (
            f"{name}: psi and phi are not given beyond t = {since:.6g}: the third axis is, "
            "or passes, too near the vertical for their turns to be counted"
        )
    if not outcome.done:
        followed = f"followed to t = {found.until:.6g}: " if outcome is Outcome.TOO_WIDE else ""
        times = f"{len(found.times)} of {len(found.scene.times)} times"
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


def _check(found: Found, asked: Namespace) -> Iterator[str]:
    if found.passed is None and not found.interrupted:
        yield (
            "polhode check: expected a case with bands of digits ([expect]), which --propose "
            "prints, or with figures"
        )


def _nothing(found: Found, asked: Namespace) -> Iterator[str]:
    yield from ()


def _search(found: Found, asked: Namespace) -> Iterator[str]:
    yield f"{found.scene.name}: {found!r}; no list is complete"


def _frequencies(found: Frequencies, asked: Namespace) -> Iterator[str]:
    for signal, lines in found.lines.items():
        if not lines:
            yield f"{found.name}: {signal} has no line above rounding"
    kind = "closed form" if found.closed_form else "basis"
    if told := ", ".join(f"{name} = {value:.15g}" for name, value in found.known.items()):
        yield f"{found.name}: {kind}: {told}"


def _proved_orbit(found: ProvedOrbit, asked: Namespace) -> Iterator[str]:
    from polhode.certificates.verdict import trusted_base

    yield (
        f"{found.scene.name}: every digit is proven; {counted(found.runs, 'run')} of the checker "
        f"at {found.bits} bits, {found.seconds:.2f} s"
    )
    yield trusted_base()


def _proved_chaos(found: ProvedChaos, asked: Namespace) -> Iterator[str]:
    from polhode.certificates.verdict import trusted_base

    yield f"{found.scene.name}: proved at try {found.tries}, {found.seconds:.2f} s"
    yield trusted_base()


_NOTES: dict[str, Callable[[Found, Namespace], Iterator[str]]] = {
    **dict.fromkeys(("list", "show", "about", "compare", "order", "levels", "verify"), _nothing),
    "check": _check,
    "run": _run,
    "reference": _reference,
    "certify": _certify,
    "sweep": _sweep,
    "section": _section,
    "map": _map,
    "orbit": _orbit,
    "orbits": _search,
    "prove orbits": _search,
    "frequencies": _frequencies,
    "prove orbit": _proved_orbit,
    "prove chaos": _proved_chaos,
}
