"""Every verb met by signals at many random moments: is each obeyed, and is nothing left behind?

    python tests/campaigns/signals_met.py [SIGNALS] [WORK...]

sends so many signals (50 if it is not said) to each work of :mod:`fuzz.signals`, or to those that
are named, and prints how often it ended with which code, and each fault.  The exit code is 1 where
there was a fault.

Last printed, with 2 signals each:

    list: codes 0: 1, 130: 1
    guide: codes 0: 2
    show: codes 130: 2
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz import signals


def main(count: str = "50", *works: str) -> int:
    """Meet them."""
    faulty = 0
    for work in works or signals.WORKS:
        codes, faults = signals.met_at_random(work, int(count), 2)
        ends = ", ".join(f"{code}: {n}" for code, n in sorted(Counter(map(str, codes)).items()))
        print(f"{work}: codes {ends}", *faults, sep="\n    ", flush=True)
        if work not in signals.QUICK and int(count) >= 20:
            under_way = sum(code not in (0, 3) for code in codes)
            faults += ["the work was hardly ever under way"] * (under_way <= 5)
        faulty += bool(faults)
    return int(faulty > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
