"""``polhode certify``: a proven enclosure of a motion, of its events too."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.scenes import start_box
from polhode.scenes.start_box import StartBox
from polhode.verbs.terminal import LONG, ProgressLine, note

if TYPE_CHECKING:
    from polhode.enclosures.result import Enclosure


def certified(
    scene: StartBox,
    digits: int = 50,
    events: bool = False,
    max_steps: int | None = None,
    max_seconds: float | None = None,
    certificate: bool = False,
    line: ProgressLine | None = None,
) -> Enclosure:
    """Enclose the exact motion of any body in proven balls.

    Parameters
    ----------
    scene : StartBox
        A case that ships, or a path; in a file omega may have intervals.
    digits : int
        Digits to prove at every time (50).
    events : bool
        Prove the scene's events, too.
    max_steps : int, optional
        A limit on the steps.
    max_seconds : float, optional
        A limit on the time in seconds; what is proven until then is printed.
    certificate : bool
        Whether a certificate is asked for.
    line : ProgressLine
        Where progress is shown.
    """
    from polhode.certificates import state_certificate
    from polhode.enclosures.certify import certify
    from polhode.enclosures.events import certify_events
    from polhode.enclosures.task import MAX_STEPS
    from polhode.judging.reference_rows import held_times

    top, radii = scene
    if events and not top.events:
        raise BadInput(top.name, "events", None, "events in the scene, for --events")
    moments = held_times(top, top.times, digits)
    if not moments:
        raise BadInput(top.name, "run.end", None, "a time, or times given with --at")
    if certificate:
        if radii is not None:
            raise BadInput(top.name, start_box.KEY, None, "numbers, for a certificate")
        state_certificate.check(top, moments)

    def foretell(seconds: float) -> None:
        if seconds > LONG:
            note(
                f"{top.name}: this proof will take about {seconds:.2g} s; "
                "--max-seconds S or Ctrl-C ends it sooner and keeps what is proven"
            )

    began = time.monotonic()
    how: dict[str, Any] = {
        "digits": digits,
        "max_steps": max_steps or MAX_STEPS,
        "max_seconds": max_seconds,
        "forecast": foretell,
        "omega_radius": radii,
        "progress": None if line is None else line.show,
    }
    enclosure = certify(top, moments, **how)
    if not events or not enclosure.outcome.done:
        return enclosure
    if max_seconds is not None:
        how["max_seconds"] = max(1e-3, max_seconds - time.monotonic() + began)
    return replace(enclosure, events=certify_events(top, max(moments, key=abs), **how))
