"""Engines that nobody uses at the moment, by what they integrate.

Whoever needs one takes it out, so that no two share one, and puts it back.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

MOST = 64  # of a few hundred kilobytes each: more kinds than the library's cases need at a time


class Pool:
    """Engines by key; of more than MOST those go first whose key was not used for longest.

    Engines come back in garbage collections, too, below any lock of the thread that collects: so
    there is no lock.  No two threads are given the same engine, for a list is never copied; one
    that comes back while another thread puts one of the same key may be lost, and is built again.
    """

    def __init__(self) -> None:
        self._idle: dict[Hashable, list[Any]] = {}

    def take(self, key: Hashable) -> Any:
        """One of a key, from now on the caller's; None where there is none."""
        try:
            return self._idle[key].pop()
        except (KeyError, IndexError):
            return None

    def put(self, key: Hashable, engine: Any) -> None:
        """Keep one for whoever asks next."""
        idle = self._idle
        engines = idle.pop(key, [])
        engines.append(engine)
        idle[key] = engines  # behind all others
        while sum(map(len, list(idle.values()))) > MOST:
            for oldest in list(idle)[:1]:
                engines = idle.get(oldest, [])
                del engines[:1]
                if not engines:
                    idle.pop(oldest, None)


#: The one of this process.
POOL = Pool()
