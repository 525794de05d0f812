"""Pages: Markdown's subset, and one HTML page that needs nothing else."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

import polhode
from polhode.studies import report
from polhode.studies.page import html
from polhode.studies.page.blocks import Figure, Heading, Items, Number, PageTable, Text, markdown
from polhode.studies.page.hero import hero

COMMITTED = Path(__file__).parents[2] / "reports"
VOID = {"meta", "br", "wbr", "hr", "img", "link", "input"}

SVG = """<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">
<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="72pt" height="36pt" viewBox="0 0 72 36" \
xmlns="http://www.w3.org/2000/svg" version="1.1">
 <metadata><rdf:RDF xmlns:dc="http://purl.org/dc/elements/1.1/"></rdf:RDF></metadata>
 <defs><path id="m1" d="M 0 0"/><clipPath id="c1"><rect width="1" height="1"/></clipPath></defs>
 <g clip-path="url(#c1)"><use xlink:href="#m1" x="1" y="2"/></g>
</svg>
"""
BLOCKS = (
    Text("A < B & *C*: `a<b` at [the source](https://example.org/x?a=1&b=2)"),
    Heading("Numbers of `double`"),
    Items(("one", "p*q - q*p stays as it is")),
    PageTable(("case", "digits"), (("a|b", "13.5"), ("`x < y`", "–")), "lr"),
    Figure("one", 'What it "shows"'),
    Figure("two", "The same again"),
    Heading("More"),
    Text("See [published](published.md) and [elsewhere](other.md)."),
)
SECTIONS = (
    html.Section("first", "First <study>", "3 < 4.", BLOCKS, {"one": SVG, "two": SVG}),
    html.Section("published", "Second", "", (Text("text"),), {}),
)


class Page(HTMLParser):
    """A page taken apart: every element closed, in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.references: list[tuple[str, str, str]] = []
        self.tags: dict[str, int] = {}
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self._element(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._element(tag, attrs)

    def _element(self, tag, attrs):
        self.tags[tag] = self.tags.get(tag, 0) + 1
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            if name.split(":")[-1] in ("href", "src", "srcset", "data", "action", "poster"):
                self.references.append((tag, name, value))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def check(text: str) -> Page:
    """A page that is well formed, names each thing once and asks the network for nothing."""
    page = Page(text)
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    assert not {"script", "link", "iframe", "object", "embed", "img", "base"} & set(page.tags)
    for tag, _, value in page.references:
        if value.startswith("#"):
            assert value[1:] in page.ids, value
        elif tag == "image":  # pixels that the figure carries itself
            assert value.startswith("data:image/png;base64,")
        elif value.endswith(".json"):  # of the same folder, for who wants the rows
            assert tag == "a"
            assert value in ("first.json", *(path.name for path in COMMITTED.glob("*.json")))
        else:
            assert tag == "a", (tag, value)
            assert value.startswith(("https://", "http://"))
    for name in re.findall(r"url\(#([^)]+)\)", text):
        assert name in page.ids
    assert "@import" not in text
    assert not re.search(r"url\((?!#)", text)
    return page


def test_the_page_is_whole_and_needs_nothing_else():
    text = html.page("A title & more", SECTIONS)
    page = check(text)
    assert page.tags["table"] == 1
    assert page.tags["figure"] == 2
    assert page.tags["svg"] == 3  # one small, on the card
    assert '<use href="#one-figure" width="72" height="36"/>' in text
    assert {"first", "published", "first-1", "first-2", "one-m1", "two-m1", "two-c1"} <= {*page.ids}
    assert "First <study>" in page.text
    assert "metadata" not in text
    assert "<!DOCTYPE svg" not in text


def test_everything_is_escaped_and_markdown_translated():
    text = html.page("t", SECTIONS)
    assert "A &lt; B &amp; <em>C</em>: <code>a&lt;b</code>" in text
    assert '<a href="https://example.org/x?a=1&amp;b=2">the source</a>' in text
    assert "p*q - q*p stays as it is" in text
    assert "<td>a|b</td>" in text
    assert 'aria-label="What it &quot;shows&quot;"' in text
    assert '<td class="r">–</td>' in text


@pytest.mark.parametrize(
    ("line", "made"),
    [
        ("2*x*y", "2*x*y"),
        ("*two words* and `a*b*c`", "<em>two words</em> and <code>a*b*c</code>"),
        ("**two**", "**two**"),
        ("1e-3 * 2 * x", "1e-3 * 2 * x"),
        ("[a](javascript:alert)", "a"),
        ("<script>alert()</script>", "&lt;script&gt;alert()&lt;/script&gt;"),
        ("*a `b*` c*", "*a <code>b*</code> c*"),
    ],
)
def test_one_line_of_markdown(line, made):
    assert html.inline(line) == made


def test_links_to_studies_lead_into_the_page_and_to_other_files_nowhere():
    text = html.page("t", SECTIONS)
    assert '<a href="#published">published</a>' in text
    assert "other.md" not in text


def test_wide_things_scroll_in_boxes_of_their_own():
    text = html.page("t", SECTIONS)
    assert text.count('<div class="wide" tabindex="0"><table>') == 1
    assert text.count('<div class="wide"><svg') == 2
    assert '<meta name="viewport"' in text
    assert "@media print" in text
    svg = re.findall(r"<svg[^>]*>", text)[0]
    assert "width=" not in svg.replace("stroke-width", "")
    assert 'viewBox="0 0 72 36"' in svg


def test_a_row_of_another_length_than_its_header_is_an_error():
    broken = html.Section("x", "x", "", (PageTable(("a", "b"), (("1",),)),), {})
    with pytest.raises(ValueError, match="zip"):
        html.page("t", [broken])


def test_markdown_of_the_same_blocks():
    text = markdown("First", BLOCKS)
    assert text.startswith("# First\n\n")
    assert "| a\\|b | 13.5 |" in text
    assert "|---|--:|" in text
    assert '![What it "shows"](one.svg)' in text


def test_the_committed_page_holds_every_table_and_figure():
    text = (COMMITTED / report.PAGE).read_text()
    page = check(text)
    tables = figures = 0
    for name in report.STUDIES:
        found = report.results(COMMITTED, name)
        assert found is not None
        assert name in page.ids
        blocks = tuple(report.blocks(found))
        tables += sum(isinstance(block, PageTable) for block in blocks)
        figures += sum(isinstance(block, Figure) for block in blocks)
    assert page.tags["table"] == tables + 1  # how each was made
    assert page.tags["figure"] == figures >= len(report.STUDIES)


def test_a_card_tells_a_sentence_and_the_section_all():
    long = "Of 3.5 runs 2 end. At t = 1 none does."
    section = html.Section("first", "First", long, BLOCKS, {"one": SVG, "two": SVG})
    text = html.page("t", [section])
    card = text[text.index("<nav") : text.index("</nav>")]
    assert "<p>Of 3.5 runs 2 end.</p>" in card
    brief = html.page("t", [section._replace(brief="In short.")])
    assert "<p>In short.</p>" in brief
    assert "Of 3.5 runs" not in brief


def test_words_stand_beside_the_one_figure_that_follows_them():
    blocks = (Heading("A"), Text("a"), Heading("B"), Text("b"), Figure("one", "1"), Text("c"))
    text = html.page("t", [html.Section("s", "S", "", blocks, {"one": SVG})])
    (pair,) = re.findall(r'<div class="pair">.*?</figure>\n</div></div>', text, re.S)
    assert "<p>b</p>" in pair
    assert "<p>a</p>" not in pair
    assert "<p>c</p>" not in pair


def test_rows_of_a_figure_may_be_fetched():
    section = SECTIONS[0]._replace(data="first.json")
    text = html.page("t", [section])
    assert text.count('<a href="first.json" download>first.json</a>') == 2


def test_the_first_screen_tells_what_it_is_and_moves():
    run = polhode.integrate("lagrange/looping", at=[0, 1, 2, 3])
    number = Number("5 of 6", "runs < all & others")
    text = html.page("t", SECTIONS, hero=hero(run, [number]), made=PageTable(("a",), (("b",),)))
    page = check(text)
    assert page.tags["animate"] == 4
    top = text[: text.index("<nav")]
    assert "heavy rigid body" in top
    assert "<b>5 of 6</b>runs &lt; all &amp; others" in top
    for values in re.findall(r'values="([^"]+)"', top):
        assert len(values.split(";")) == 4
    assert text.index("How this was made") > text.index("<h2>Second")


def test_the_committed_page_begins_with_numbers_of_its_rows():
    text = (COMMITTED / report.PAGE).read_text()
    top = text[: text.index("<nav")]
    assert top.count("<li><b>") == 2
    assert "Provenance" not in text
