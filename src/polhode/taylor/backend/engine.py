"""heyoka, or what stands for it where it is not installed: every module imports, no call works.

So results of any kind are read, judged against a closed form, drawn and saved without it; whatever
integrates says in one line how to get it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn, TypeVar

__all__ = ["NoHeyoka", "constant", "hy", "installed"]

T = TypeVar("T")


class NoHeyoka(ModuleNotFoundError):
    """Something has to be integrated, and heyoka is not installed."""

    def __init__(self) -> None:
        told = "heyoka: expected to be installed, since integration needs it: "
        told += "conda install -c conda-forge heyoka.py, or on Linux pip install heyoka"
        super().__init__(told, name="heyoka")


class Missing:
    """heyoka or a part of it, where it is not installed: a name until it is called."""

    def __getattr__(self, name: str) -> Missing:
        if name.startswith("__"):
            raise AttributeError(name)
        return Missing()

    def __call__(self, *given: object, **named: object) -> NoReturn:
        """Refuse: there is nothing to call."""
        raise NoHeyoka

    __int__ = __call__


#: Whether something can be integrated here.
installed = True
if TYPE_CHECKING:
    import heyoka as hy
else:
    try:
        import heyoka as hy
    except ModuleNotFoundError as fault:
        if fault.name != "heyoka":
            raise
        hy, installed = Missing(), False
    else:
        # heyoka logs on stdout, the place for results.  What it has to say is known from
        # elsewhere: a cache that cannot be used costs compiling again and shows in
        # ``heyoka_numbers.cache``; a multiple zero that it gives up on is found through the
        # derivative, or shows in ``EventTimes.complete``.
        hy.set_logger_level_critical()


def constant(make: Callable[[], T]) -> T:
    """What heyoka makes once, when a module is imported; raises nothing where it is missing."""
    try:
        return make()
    except NoHeyoka:
        missing: T = Missing()  # type: ignore[assignment]
        return missing
