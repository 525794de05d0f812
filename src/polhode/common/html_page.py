"""A page of HTML that is a result: saved, or shown by a notebook in its place."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from polhode.common.arguments import of_kind
from polhode.common.files import check_writable, write_whole


@dataclass(frozen=True, repr=False)
class Page:
    """A motion as an HTML page: ``text``, to be saved; a notebook displays it.

    >>> import polhode
    >>> page = polhode.view("lagrange/looping", end=4)
    >>> page.name, 90_000 < len(page.text) < 200_000
    ('lagrange/looping', True)
    """

    name: str
    text: str

    def __repr__(self) -> str:
        return f"<Page of {self.name}: {round(len(self.text.encode()) / 1000)} kB>"

    def _repr_html_(self) -> str:
        frame = "width:100%;height:46rem;border:0"
        return f'<iframe style="{frame}" srcdoc="{escape(self.text)}"></iframe>'

    def save(self, path: str | Path) -> None:
        """Write it; the name ends in .html."""
        of_kind("save", "path", path, (str, Path), "the path of an .html file")
        check_writable(Path(path), [".html"])
        write_whole({Path(path): self.text})


_SEVERAL = """\
<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 1rem/1.5 system-ui, sans-serif; max-width: 72rem; margin: 0 auto; padding: 1rem }}
</style>
{heading}
{words}
{frames}
</html>
"""


def together(pages: Sequence[Page], title: str = "", text: str = "") -> Page:
    """Pages in frames one below the other, under a title and a text in paragraphs."""
    words = [
        f"<p>{escape(part.strip())}</p>" for part in re.split(r"\n\s*\n", text) if part.strip()
    ]
    frames = [f"<h2>{escape(page.name)}</h2>\n{page._repr_html_()}" for page in pages]
    name = title or ", ".join(page.name for page in pages)
    heading = f"<h1>{escape(title)}</h1>" * bool(title)
    parts = {"words": "\n".join(words), "frames": "\n".join(frames), "heading": heading}
    return Page(name, _SEVERAL.format(title=escape(name), **parts))
