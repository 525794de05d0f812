"""Classes of cases made from a seed, beside those of :mod:`fuzz.generate`.

Each maker changes what it must in the present folder and gives how the case is written and the
work, for :mod:`fuzz.promise`: the words of a command, or anything to call.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import polhode
from fuzz.changed_files import archive, kept
from fuzz.hostile_motions import body, event, proof, units
from fuzz.hostile_words import dynamic, film, toml, wide

#: How a class is made; a command where it gives words.
MAKERS: dict[str, Callable[[Random, polhode.Scene], tuple[str, Any]]] = {
    **{"archive": archive, "event": event, "proof": proof, "kept": kept, "body": body},
    **{"units": units, "wide": wide, "toml": toml, "dynamic": dynamic, "film": film},
}
