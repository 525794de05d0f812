"""JSON and pages, as polhode writes them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from typing import Any, TypeAlias

from polhode.common.arguments import of_kind
from polhode.common.files import check_writable, write_whole

# --- json text ------------------------------------------------------------------------------------
#
# JSON for people and programs: objects as Python has them, and their text.


#: Keys, and what JSON can hold: text, numbers, true, false, null, lists, objects.
JsonObject: TypeAlias = dict[str, Any]


def as_json(value: object) -> str:
    """JSON text, ASCII: a line for each key and each row of a table, and for what one column is."""
    from json import dumps

    return _json(value, 0, partial(dumps, ensure_ascii=True, allow_nan=False)) + "\n"


def _json(value: object, depth: int, dumps: Callable[[object], str]) -> str:
    inner, outer = "\n" + " " * (depth + 1), "\n" + " " * depth
    if isinstance(value, dict) and value:
        if depth > 1 and not any(isinstance(x, (list, dict)) for x in value.values()):
            return dumps(value)
        lines = [f"{dumps(str(k))}: {_json(v, depth + 1, dumps)}" for k, v in value.items()]
        return "{" + inner + ("," + inner).join(lines) + outer + "}"
    if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
        lines = [_json(v, depth + 1, dumps) for v in value]
        return "[" + inner + ("," + inner).join(lines) + outer + "]"
    return dumps(value)


# --- html page ------------------------------------------------------------------------------------
#
# A page of HTML that is a result: saved, or shown by a notebook in its place.


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


def together(pages: Sequence[Page], title: str = "", text: str = "") -> Page:
    """Pages in frames one below the other, under a title and a text in paragraphs.

    One page without title and text is itself.
    """
    if len(pages) == 1 and not title and not text:
        return pages[0]
    paragraphs = [part.strip() for part in re.split(r"\n\s*\n", text)]
    words = [f"<p>{escape(paragraph)}</p>" for paragraph in paragraphs if paragraph]
    frames = [f"<h2>{escape(page.name)}</h2>\n{page._repr_html_()}" for page in pages]
    name = title or ", ".join(page.name for page in pages)
    heading = f"<h1>{escape(title)}</h1>" * bool(title)
    parts = {"words": "\n".join(words), "frames": "\n".join(frames), "heading": heading}
    template = Path(__file__).with_name("several_pages.html").read_text("utf-8")
    return Page(name, template.format(title=escape(name), **parts))
