"""What limits the digits of a trajectory: rounding, conditioning, method or reference."""

from __future__ import annotations

WITHIN = 1.0  # digits: kappa·eps bounds an error, which seldom comes nearer to it
KAPPA_TAKES = 2.0  # digits: what the problem takes before it is named


def limit(digits: float, held: float, possible: float | None, reference: float, steps: str) -> str:
    """The name of what limits so many correct digits.

    ``held``: the most that the number type holds.  ``possible``: those that the problem allows.
    ``reference``: those that the reference is good for, inf for a closed form.
    *reference*: it is not good for more.  *rounding*: these are the type's own last digits, or
    rounding the inputs and the time leaves no more.  *conditioning*: likewise, and it is the
    motion that makes these few.  *method*: the problem would allow more; ``steps`` says what the
    method does.  An unknown ``possible`` counts as more.
    """
    if reference < digits + WITHIN:
        return "reference"
    if digits >= held - WITHIN:
        return "rounding"
    if possible is None or digits < possible - WITHIN:
        return f"method ({steps})"
    return "conditioning" if possible < held - KAPPA_TAKES else "rounding"


def is_lost(digits: float, possible: float | None) -> bool:
    """Whether kappa leaves no digit there, and none was found either."""
    return possible == 0 and digits < 1


def shown_digits(digits: float, possible: float | None) -> str:
    """Correct digits for people; never a number where none is left."""
    return "none left" if is_lost(digits, possible) else f"{digits:.2f}"


def shown_possible(possible: float | None) -> str:
    """Digits possible for people."""
    if possible is None:
        return "unknown"
    return "none" if possible == 0 else f"{possible:.2f}"
