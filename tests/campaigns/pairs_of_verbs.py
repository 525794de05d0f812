"""All pairs of verbs in threads at once: does each answer to the bit as it does alone?

    python tests/campaigns/pairs_of_verbs.py [VERB...]

asks forty times for each pair with the verbs that are named, or for all pairs, and prints the verbs
whose answers differ; then it asks all of them in pools of processes, begun in each way.  The exit
code is 1 where one differs.

Last printed, of ``show`` with each of the verbs and of the pools (begun by fork, spawn and
forkserver): no verb whose answer differs.
"""

from __future__ import annotations

import multiprocessing
import sys
from itertools import combinations_with_replacement
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from shared.verbs import VERBS, alone, in_pool, together

QUESTIONS = 40


def main(*names: str) -> int:
    """Ask them."""
    sys.setswitchinterval(1e-5)
    faulty = 0
    for pair in combinations_with_replacement(VERBS, 2):
        if names and not {*names} & {*pair}:
            continue
        wrong = together(sorted({*pair}), QUESTIONS)
        faulty += bool(wrong)
        print(" and ".join(pair), *wrong, sep=": ", flush=True)
    expected = [alone(name) for name in VERBS]
    for start in multiprocessing.get_all_start_methods():
        answers = in_pool(start, [*VERBS])
        wrong = [n for n, x, y in zip(VERBS, answers, expected, strict=True) if x != y]
        faulty += bool(wrong)
        print(f"a pool by {start}", *wrong, sep=": ", flush=True)
    return int(faulty > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
