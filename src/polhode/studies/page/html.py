"""All pages as one HTML page that needs nothing else: figures inside, no scripts, no network."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from typing import NamedTuple

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text


class Section(NamedTuple):
    """One study's page: its name, title, what it found, blocks, and figures as SVG by name."""

    name: str
    title: str
    finding: str
    blocks: tuple[Block, ...]
    figures: Mapping[str, str]


def page(title: str, sections: Iterable[Section], lead: str = "") -> str:
    """The sections as one page; ``lead``: the one that stands before the table of contents."""
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
            f"<style>{_STYLE}</style>",
            "</head>",
            "<body>",
            f"<h1>{escape(title)}</h1>",
            *(line for section in first for line in _section(section, names, folded=False)),
            *_contents(others),
            *(line for section in others for line in _section(section, names)),
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
    yield '<nav aria-label="Contents">'
    yield "<ol>"
    for section in sections:
        yield f'<li><a href="#{section.name}">{escape(section.title)}</a>'
        yield f"<p>{inline(section.finding)}</p>"
        yield "<details><summary>sections</summary><ul>"
        for slug, text in _headings(section):
            yield f'<li><a href="#{slug}">{inline(text)}</a></li>'
        yield "</ul></details></li>"
    yield "</ol>"
    yield "</nav>"


def _headings(section: Section) -> Iterator[tuple[str, str]]:
    """Identifier and text of each heading of a section."""
    texts = (block.text for block in section.blocks if isinstance(block, Heading))
    for k, text in enumerate(texts, start=1):
        yield f"{section.name}-{k}", text


def _section(section: Section, names: set[str], folded: bool = True) -> Iterator[str]:
    yield f'<section id="{section.name}">'
    yield f"<h2>{escape(section.title)}</h2>"
    slugs = (slug for slug, _ in _headings(section))
    for block in section.blocks:
        match block:
            case Heading(text):
                yield f'<h3 id="{next(slugs)}">{inline(text, names)}</h3>'
            case Text(text):
                yield f"<p>{inline(text, names)}</p>"
            case Items(items):
                yield "<ul>"
                yield from (f"<li>{inline(item, names)}</li>" for item in items)
                yield "</ul>"
            case PageTable():
                yield from _table(block, names, folded)
            case Figure(name, alt):
                yield f'<figure><div class="wide">{_svg(section.figures[name], name, alt)}</div>'
                yield f"<figcaption>{inline(alt, names)}</figcaption></figure>"
    yield "</section>"


def _table(table: PageTable, names: set[str], folded: bool) -> Iterator[str]:
    sides = table.align or "l" * len(table.header)
    if folded:
        columns = escape(", ".join(table.header[:3]))
        count = "1 row" if len(table.rows) == 1 else f"{len(table.rows)} rows"
        yield f'<details class="rows"><summary>{count}: {columns}, …</summary>'
    yield '<div class="wide" tabindex="0"><table>'
    yield f"<thead>{_row('th', table.header, sides, names)}</thead>"
    yield "<tbody>"
    yield from (_row("td", row, sides, names) for row in table.rows)
    yield "</tbody></table></div>"
    if table.told:
        yield f'<p class="again">{inline(table.told)}</p>'
    if folded:
        yield "</details>"


def _row(tag: str, cells: Iterable[str], sides: str, names: set[str]) -> str:
    made = (
        f"<{tag}{_kind(cell, side)}>{_cell(cell, names)}</{tag}>"
        for cell, side in zip(cells, sides, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


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
    head = re.sub(r'\s(?:width|height|role|aria-label)="[^"]*"', "", head)
    head += f'{most} role="img" aria-label="{escape(alt)}"'
    own = f"{name}-"
    body = re.sub(r'\bid="([^"]+)"', rf'id="{own}\1"', f"{head}>{rest}")
    body = re.sub(r'href="#([^"]+)"', rf'href="#{own}\1"', body)
    return re.sub(r"url\(#([^)]+)\)", rf"url(#{own}\1)", body)


_STYLE = """
:root { font: 16px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; color: #1b1b1b; }
body { max-width: 80rem; margin: 0 auto; padding: 1rem; background: #fff; }
h1 { font-size: 1.6rem; line-height: 1.2; }
h2 { font-size: 1.3rem; line-height: 1.25; margin-top: 3rem; border-top: 2px solid #0072b2;
     padding-top: .6rem; }
h3 { font-size: 1.05rem; margin: 1.2rem 0 .3rem; }
p, li, figcaption { max-width: 46rem; overflow-wrap: anywhere; }
a { color: #005a9c; }
code { font: .9em ui-monospace, "DejaVu Sans Mono", monospace; background: #f2f2f2;
       padding: 0 .2em; }
nav ol { padding-left: 1.4rem; }
nav p { margin: 0; }
nav details { font-size: .85rem; color: #555; }
nav ul { padding-left: 1rem; font-size: .85rem; list-style: none; columns: 18rem; }
.wide { overflow-x: auto; max-width: 100%; }
.wide { background: linear-gradient(90deg, #fff 30%, #fff0) left / 3rem 100% local no-repeat,
                    linear-gradient(270deg, #fff 30%, #fff0) right / 3rem 100% local no-repeat,
                    linear-gradient(270deg, #0003, #0000) right / .8rem 100% scroll no-repeat; }
details.rows > summary { cursor: pointer; color: #005a9c; font-size: .85rem; margin: .3rem 0; }
table { border-collapse: collapse; font-size: .75rem; font-variant-numeric: tabular-nums;
        margin: .5rem 0; }
th, td { padding: .2rem .45rem; border-bottom: 1px solid #ddd; text-align: left;
         vertical-align: top; white-space: nowrap; }
td.long { white-space: normal; min-width: 18rem; max-width: 30rem; }
th { border-bottom: 2px solid #999; }
th.r, td.r { text-align: right; }
p.again { font-size: .75rem; color: #444; margin: 0 0 .6rem; }
tbody tr:nth-child(even) { background: #0000000a; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; }
#gallery figure svg { width: 20rem; max-width: 100%; }
figcaption { font-size: .85rem; color: #444; margin-top: .3rem; }
@media (max-width: 40rem) {
  td:not(.r) { white-space: normal; min-width: 6.5rem; }
  th:first-child, td:first-child { position: sticky; left: 0; background: #fff;
                                   white-space: normal; overflow-wrap: anywhere;
                                   min-width: 7rem; max-width: 8.5rem; }
  #needs th, #needs td { padding: .2rem .25rem; min-width: 0; }
  #needs td:first-child { min-width: 4.5rem; }
  #needs td code { overflow-wrap: anywhere; font-size: .62rem; }
}
@page { size: landscape; margin: 1cm; }
@media print {
  body { max-width: none; padding: 0; }
  .wide { overflow: visible; }
  nav { display: none; }
  figure svg { min-width: 0; max-height: 17cm; }
  table { font-size: .55rem; }
  th, td:not(.r) { white-space: normal; padding: .1rem .25rem; }
  td.long { min-width: 0; overflow-wrap: anywhere; }
  h2 { break-before: page; }
  tr, figure { break-inside: avoid; }
  thead { display: table-header-group; }
}
"""
