"""``polhode orbit``: one periodic orbit, near a scene's start or out of a search of its level."""

from __future__ import annotations

from pathlib import Path

from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.dynamics.families import picked
from polhode.dynamics.orbit import DIGITS, Orbit
from polhode.dynamics.orbit import orbit as near
from polhode.numbers.number_types import AnyNumber
from polhode.scenes import library


def orbit(
    scene: str | Path,
    digits: int = DIGITS,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    period: AnyNumber | None = None,
    returns: int | None = None,
    search: tuple[int, int] | None = None,
    pick: int | None = None,
    progress: Message | None = None,
) -> Orbit:
    """Find a periodic orbit of omega and gamma, to the digits wanted.

    Parameters
    ----------
    scene : Scene, str or Path
        A case that ships, or a path.
    digits : int
        The correct digits of start and period (15).
    h, f : number, optional
        The level's energy h or vertical momentum f, if not the scene's.
    period : number, optional
        A guess of the period.
    returns : int, optional
        The number of near returns of the motion to try (10), in a search of crossings (3).
    search : tuple of int, optional
        Cells of the level's section to search for orbits, of which --pick chooses one.
    pick : int, optional
        The number of an orbit of the search, as polhode orbits lists them.
    progress : callable, optional
        Called with a line of text now and then.
    """
    if search is None and pick is None:
        return near(scene, digits, h, f, period, returns, progress)
    top = library.load(scene)
    if period is not None:
        raise BadInput(top.name, "--search", None, "no --period with it")
    return picked(top, search, pick, returns, h, f, progress, digits)
