"""Programs that tell the tests how far they are, so that none waits by the clock."""

from __future__ import annotations

#: ``polhode``, but that it prints a line as soon as it takes steps.
STEPPING = """
import sys
from polhode.cli import main
from polhode.taylor.motion import Motion
chunk = Motion._chunk
def announced(self, *given):
    Motion._chunk = chunk
    print("steps", flush=True)
    return chunk(self, *given)
Motion._chunk = announced
sys.exit(main())
"""
