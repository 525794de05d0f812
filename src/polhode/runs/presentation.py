"""What higher rooms do for trajectories, beside what they do for all results."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from matplotlib.axes import Axes

    from polhode.common.html_page import Page
    from polhode.numbers.rows import Reread
    from polhode.numbers.scalars import AnyNumber

R_contra = TypeVar("R_contra", contravariant=True)


class RunPresentation(Protocol[R_contra]):
    """A trajectory drawn in one of many ways, and as a page."""

    def plot(
        self, run: R_contra, what: str, axes: object, end: AnyNumber | None, /
    ) -> Axes | npt.NDArray[np.object_]:
        """Draw a figure of it: the axes drawn into."""
        ...

    def view(self, run: R_contra, end: AnyNumber | None, /) -> Page:
        """A page on which it moves."""
        ...


class Reevaluation(Protocol[R_contra]):
    """A trajectory made once more: what makes one is above it, too."""

    def at_times(self, run: R_contra, what: str, t: AnyNumber | Iterable[AnyNumber], /) -> Reread:
        """Angles or attitude at time t, or rows of them."""
        ...
