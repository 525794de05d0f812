"""A family of closed forms: how it places a scene in axes of its own, and solves it there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import Any, TypeAlias

from polhode.closed_forms.balls.frames import Frame, Motion
from polhode.closed_forms.membership import Misfit, PrincipalScene
from polhode.numbers.exact import ONE, Exact
from polhode.numbers.mpmath_context import mpf

#: What :attr:`Placement.proven` says where the attitude has no formula.
ENCLOSED_ATTITUDE = "states are proven by the closed form, the attitude by an enclosure"


@dataclass(kw_only=True)
class Placement:
    """A body and its start in the axes and units of a family, exact, with the kind of motion.

    A family adds the exact numbers of its formulas.
    """

    regime: StrEnum | str
    #: The family's axes within the principal ones.
    frame: Frame
    #: So many of the family's units of rates make one of the scene's; negative: time runs back.
    unit: Fraction = Fraction(1)
    #: The length of the family's vertical, negative in axes that are the opposites of the frame's.
    vertical: Exact = ONE
    #: The conditions that body and start meet, where the family names them.
    held: tuple[str, ...] = ()
    #: Whether theorems and balls prove every digit, or a text that says what else they rest on;
    #: False: the digits are only reproduced, with more bits.
    proven: bool | str = True
    #: Whether it has the attitude too; else a reference encloses it.
    has_attitude: bool = True
    #: Whether a row costs so much that of a table of very many only some are judged.
    is_dear: bool = False
    #: Of which axis about which a frequency is, by its name, where the name leaves it open.
    rates_of: Mapping[str, str] = field(default_factory=dict)

    def most_bits(self, digits: int) -> int | None:
        """A cap on the bits of so many digits, in place of the usual one."""
        del digits
        return None

    def curve_of(self, numbers: Mapping[str, mpf]) -> dict[str, object]:
        """The curve of a motion, from the numbers that the motion tells of it."""
        return dict(numbers)


#: What decides whether a scene belongs to a family, and where it is in the family's axes then.
Place: TypeAlias = Callable[[PrincipalScene], Placement | None]


@dataclass(frozen=True)
class Family:
    """One family of closed forms.

    ``name``: the word of ``reference.kind`` in a scene file.  ``place``: a scene in the family's
    axes, found by exact arithmetic alone; None of one that does not belong.  ``misfit``: why one
    does not; None of one that belongs.  ``solve``: the motion of a placement at the precision in
    force; it imports what it needs when it is called.
    """

    name: str
    place: Place
    misfit: Callable[[PrincipalScene], Misfit | None]
    solve: Callable[[Any], Motion]
