"""Part of a study: the rows whose names hold every text that was asked for."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Only:
    """What is wanted of a study, asked with the labels of a row: ``only("euler/rest", "quad")``.

    A row is wanted where each text stands in one of its labels, capitals or not; without texts
    every row is.  ``passed``: the labels of rows that were not wanted, for the message where none
    was; ``taken``: those of rows that were.
    """

    texts: tuple[str, ...] = ()
    taken: list[str] = field(default_factory=list, compare=False)
    passed: list[str] = field(default_factory=list, compare=False)

    def __call__(self, *labels: str) -> bool:
        """Whether the row of these labels is wanted."""
        wanted = all(any(t.lower() in x.lower() for x in labels) for t in self.texts)
        (self.taken if wanted else self.passed).extend(labels)
        return wanted
