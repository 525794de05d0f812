"""All pages as one HTML page that needs nothing else: figures inside, no scripts, no network."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import NamedTuple, TypeAlias

from polhode.figures.canvas.mark_titles import CLASS
from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text
from polhode.studies.page.style import STYLE


class Section(NamedTuple):
    """One study's page: its name, title, what it found, blocks, and figures as SVG by name.

    ``brief``: the finding in a sentence, its first unless given; ``data``: the file of its rows.
    """

    name: str
    title: str
    finding: str
    blocks: tuple[Block, ...]
    figures: Mapping[str, str]
    brief: str = ""
    data: str = ""


def page(
    title: str,
    sections: Iterable[Section],
    lead: str = "",
    hero: Iterable[str] = (),
    made: PageTable | None = None,
) -> str:
    """The sections as one page.

    ``lead``: the section that stands before the table of contents; ``hero``: lines of HTML before
    that; ``made``: how each was made, at the end.
    """
    sections = tuple(sections)
    names = {section.name for section in sections}
    first = [_tables_first(section) for section in sections if section.name == lead]
    others = tuple(section for section in sections if section.name != lead)
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title>",
            f"<style>{STYLE}</style>",
            "</head>",
            "<body>",
            f"<h1>{escape(title)}</h1>",
            *hero,
            *(line for section in first for line in _section(section, names, folded=False)),
            *_contents(others),
            *(line for section in others for line in _section(section, names)),
            *([] if made is None else _made(made, names)),
            "</body>",
            "</html>",
            "",
        ]
    )


def _tables_first(section: Section) -> Section:
    """The section with its tables before everything else."""
    blocks = sorted(section.blocks, key=lambda block: not isinstance(block, PageTable))
    return section._replace(blocks=tuple(blocks))


def inline(text: str, pages: Iterable[str] = ()) -> str:
    """One line of Markdown as HTML: `code`, *emphasis*, links; everything else escaped.

    ``pages``: names whose Markdown files are sections of this page.
    """
    return "".join(_pieces(text, frozenset(pages)))


_CASE = re.compile(r"\w+/[\w-]+")
_LONG = 48  # characters of a cell that may be broken into lines

_MARK = re.compile(
    r"`(?P<code>[^`]+)`"
    r"|\[(?P<words>[^\]]+)\]\((?P<target>[^()\s]+)\)"
    r"|(?<![\w*])\*(?P<stress>[^\s*`](?:[^*`]*[^\s*`])?)\*(?![\w*])"
)


def _pieces(text: str, pages: frozenset[str]) -> Iterator[str]:
    done = 0
    for mark in _MARK.finditer(text):
        yield escape(text[done : mark.start()])
        done = mark.end()
        if mark["code"] is not None:
            yield f"<code>{escape(mark['code'])}</code>"
        elif mark["stress"] is not None:
            yield f"<em>{inline(mark['stress'], pages)}</em>"
        else:
            yield _link(mark["words"], mark["target"], pages)
    yield escape(text[done:])


def _link(words: str, target: str, pages: frozenset[str]) -> str:
    inside = inline(words, pages)
    if target.removesuffix(".md") in pages:
        target = "#" + target.removesuffix(".md")
    if not target.startswith(("https://", "http://", "#")):
        return inside  # of a file that is not here
    return f'<a href="{escape(target)}">{inside}</a>'


def _contents(sections: tuple[Section, ...]) -> Iterator[str]:
    """A card a section: its first figure, small, its title, and its finding in a sentence."""
    yield '<nav aria-label="Contents">'
    yield "<ol>"
    for section in sections:
        first = next(iter(section.figures), None)
        small = "" if first is None else _thumbnail(section.figures[first], first)
        link = f'<a href="#{section.name}">{escape(section.title)}</a>'
        yield f"<li>{small}{link}"
        yield f"<p>{inline(section.brief or _first_sentence(section.finding))}</p>"
        yield "<details><summary>sections</summary><ul>"
        for slug, text in _headings(section):
            yield f'<li><a href="#{slug}">{inline(text)}</a></li>'
        yield "</ul></details></li>"
    yield "</ol>"
    yield "</nav>"


def _thumbnail(svg: str, name: str) -> str:
    """A figure of the page once more, small: a reference to it, no copy."""
    box = re.search(r'viewBox="([^"]+)"', svg)
    if box is None:
        return ""
    *_, width, height = box[1].split()
    size = f'width="{width}" height="{height}"'
    return (
        f'<svg viewBox="0 0 {width} {height}" preserveAspectRatio="xMidYMin slice" '
        'aria-hidden="true">'
        f'<use href="#{name}-figure" {size}/></svg>'
    )


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=[^A-Z]\.) (?=[A-Z])", text, maxsplit=1)[0]


def _made(table: PageTable, names: set[str]) -> Iterator[str]:
    yield '<section id="made">'
    yield "<h2>How this was made</h2>"
    yield (
        "<p>Each study was made by the command below; no number was edited by hand. <code>polhode "
        "study NAME -o DIR</code> makes one study again; with <code>--only 'PART OF ITS "
        "NAME'</code> it makes single rows, which it prints. The key is a fingerprint of the code "
        "that the rows import, of the cases and of the versions.</p>"
    )
    yield from _table(table, names, folded=False)
    yield "</section>"


def _headings(section: Section) -> Iterator[tuple[str, str]]:
    """Identifier and text of each heading of a section."""
    texts = (block.text for block in section.blocks if isinstance(block, Heading))
    for k, text in enumerate(texts, start=1):
        yield f"{section.name}-{k}", text


def _section(section: Section, names: set[str], folded: bool = True) -> Iterator[str]:
    yield f'<section id="{section.name}">'
    yield f"<h2>{escape(section.title)}</h2>"
    slugs = (slug for slug, _ in _headings(section))
    for words, figures, table in _groups(section.blocks):
        text = [line for block in words for line in _words(block, names, slugs)]
        drawn = [line for block in figures for line in _figure(block, section, names)]
        if text and len(figures) == 1:  # beside each other where there is room
            text = ['<div class="pair"><div>', *text, "</div><div>", *drawn, "</div></div>"]
        else:
            text += drawn
        yield '<div class="group whole">' if figures or not folded else '<div class="group">'
        yield from text
        if table is not None:
            yield from _table(table, names, folded)
        yield "</div>"
    yield "</section>"


_Group: TypeAlias = tuple[list[Heading | Text | Items], list[Figure], PageTable | None]


def _groups(blocks: Iterable[Block]) -> Iterator[_Group]:
    """Words, the figures that follow them, and the table that follows these."""
    words: list[Heading | Text | Items] = []
    figures: list[Figure] = []
    for block in blocks:
        if isinstance(block, PageTable):
            yield words, figures, block
            words, figures = [], []
        elif isinstance(block, Figure):
            figures.append(block)
        else:
            if figures or (isinstance(block, Heading) and words):
                yield words, figures, None
                words, figures = [], []
            words.append(block)
    if words or figures:
        yield words, figures, None


def _words(block: Heading | Text | Items, names: set[str], slugs: Iterator[str]) -> Iterator[str]:
    match block:
        case Heading(text):
            yield f'<h3 id="{next(slugs)}">{inline(text, names)}</h3>'
        case Text(text):
            yield f"<p>{inline(text, names)}</p>"
        case Items(items):
            yield "<ul>"
            yield from (f"<li>{inline(item, names)}</li>" for item in items)
            yield "</ul>"


def _figure(block: Figure, section: Section, names: set[str]) -> Iterator[str]:
    drawn = _svg(section.figures[block.name], block.name, block.alt)
    yield f'<figure><div class="wide">{drawn}</div>'
    yield f"<figcaption>{inline(block.alt, names)}</figcaption>"
    if section.data:
        file = escape(section.data)
        yield f'<p class="data">Data: <a href="{file}" download>{file}</a></p>'
    yield "</figure>"


def _table(table: PageTable, names: set[str], folded: bool) -> Iterator[str]:
    sides = table.align or "l" * len(table.header)
    if folded:
        columns = escape("; ".join(table.header[:3]))
        count = "1 row" if len(table.rows) == 1 else f"{len(table.rows)} rows"
        yield f'<details class="rows"><summary>{count}: {columns}; …</summary>'
    yield '<div class="wide" tabindex="0"><table>'
    titles = table.meanings or [""] * len(table.header)
    yield f"<thead>{_row('th', table.header, sides, names, titles)}</thead>"
    yield "<tbody>"
    yield from (_row("td", row, sides, names) for row in table.rows)
    yield "</tbody></table></div>"
    if table.explained:
        yield '<ul class="columns">'
        for headers, meaning in table.explained:
            yield f"<li><dfn>{inline(headers)}</dfn>: {inline(meaning, names)}</li>"
        yield "</ul>"
    if table.told:
        yield f'<p class="again">{inline(table.told)}</p>'
    if folded:
        yield "</details>"


def _row(
    tag: str, cells: Sequence[str], sides: str, names: set[str], titles: Iterable[str] = ()
) -> str:
    """A row of a table; ``titles``: what is shown of each cell while a pointer rests on it."""
    made = (
        f"<{tag}{_kind(cell, side)}{_title(title)}>{_cell(cell, names)}</{tag}>"
        for cell, side, title in zip(cells, sides, titles or [""] * len(cells), strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def _title(text: str) -> str:
    return f' title="{escape(_MARK.sub(_plain, text))}"' if text else ""


def _plain(mark: re.Match[str]) -> str:
    """The words of a mark of Markdown."""
    return str(mark["code"] or mark["words"] or mark["stress"])


def _cell(cell: str, names: set[str]) -> str:
    """A cell's text; the name of a case may be broken after its slash."""
    return cell.replace("/", "/<wbr>") if _CASE.fullmatch(cell) else inline(cell, names)


def _kind(cell: str, side: str) -> str:
    """The class of a cell: to the right, or long enough to be broken into lines."""
    if side == "r":
        return ' class="r"'
    return ' class="long"' if len(cell) > _LONG else ""


def _svg(text: str, name: str, alt: str) -> str:
    """An SVG drawing as part of the page: its size left to the page, its identifiers its own.

    It is shown at most a fifth larger than it was drawn.
    """
    text = text[text.index("<svg") :].rstrip()
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    head, rest = text.split(">", 1)
    width = re.search(r'\swidth="([\d.]+)pt"', head)
    most = f' style="max-width: {1.6 * float(width[1]):.0f}px"' if width else ""
    head = re.sub(r'\s(?:id|width|height|role|aria-label)="[^"]*"', "", head)
    own = f"{name}-"
    body = re.sub(r'\bid="([^"]+)"', rf'id="{own}\1"', f"{head}>{rest}")
    role = "group" if f'class="{CLASS}"' in text else "img"  # an image hides what its marks say
    named = f'<svg id="{own}figure"{most} role="{role}" aria-label="{escape(alt)}"'
    body = body.replace("<svg", named, 1)
    body = re.sub(r'href="#([^"]+)"', rf'href="#{own}\1"', body)
    return re.sub(r"url\(#([^)]+)\)", rf"url(#{own}\1)", body)
