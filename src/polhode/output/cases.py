"""The cases that ship, as a result: what ``polhode list`` shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from polhode.common.errors import BadInput, counted, listed
from polhode.common.values import ByValue
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library


@dataclass(frozen=True, repr=False, eq=False)
class Cases(Result, ByValue):
    """Cases by name, each with its title, tags, regime and reference.

    >>> import polhode
    >>> cases = polhode.cases()
    >>> cases.entries["lagrange/nutation"].regime, "lagrange/nutation" in cases.column("scene")
    ('nutation', True)
    """

    entries: Mapping[str, library.Entry]

    def __repr__(self) -> str:
        return f"<Cases: {counted(len(self.entries), 'case')}>"

    def table(self) -> Table:
        """One row per case; tags with blanks between."""
        each = self.entries.values()
        names = ("reference", "regime", "title")
        columns = {"scene": [*self.entries]} | {k: [getattr(x, k) for x in each] for k in names}
        tags = Column("tags", [" ".join(x.tags) for x in each], type=TEXT, digits=0)
        return Table([*(Column(name, x, type=TEXT) for name, x in columns.items()), tags])

    def facts(self) -> list[Fact]:
        """None: the table tells all."""
        return []


def cases(tag: str | None = None) -> Cases:
    """List the cases that ship, with regime and reference.

    Parameters
    ----------
    tag : str, optional
        Only the cases with this tag.

    Returns
    -------
    Cases
        A result with a row for each case.

    Raises
    ------
    BadInput
        A tag that no case has.

    Examples
    --------
    >>> import polhode
    >>> polhode.cases("chaotic").column("scene")[:2]
    ['general/asymmetric-chaotic', 'general/section']
    """
    entries = library.entries()
    chosen = {name: entries.get(name) or entry_of(name) for name in library.names()}
    tags = sorted({word for entry in chosen.values() for word in entry.tags})
    if tag is not None and tag not in tags:
        raise BadInput("list", "--tag", tag, f"one of the tags {listed(tag, tags)}")
    return Cases({name: x for name, x in chosen.items() if tag is None or tag in x.tags})


def entry_of(name: str) -> library.Entry:
    """What is listed of a case, from its file."""
    from polhode.judging.reference import reference as reference_of

    scene = library.load(name)
    reference = reference_of(scene)
    return library.Entry(scene.title, scene.tags, reference.regime, reference.kind)
