"""One HTML page of all Markdown pages, which needs nothing else."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from polhode.cli import main
from polhode.studies import report
from polhode.studies.page.html import html

COMMITTED = Path(__file__).parents[2] / "reports"
VOID = {"meta", "br", "hr", "img"}
SVG = '<?xml version="1.0"?>\n<svg viewBox="0 0 1 1"><path d="M 0 0"/></svg>\n'
TEXTS = {
    "first.svg": SVG,
    "first.md": """# First <study>

A < B & *C*: `a<b` at [the source](https://example.org/x?a=1&b=2), <script>alert()</script>

| case | digits |
|---|--:|
| `x < y`, a\\|b | 13.5 |

## Numbers & more

![What it "shows"](first.svg)
""",
    "second.md": "# Second\n\nSee [first](first.md).\n",
}


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
    assert not {"script", "link", "iframe", "object", "embed", "base", "svg"} & set(page.tags)
    for tag, _, value in page.references:
        if tag == "img":  # a figure, inside
            assert value.startswith("data:image/svg+xml;base64,")
        else:
            assert tag == "a", (tag, value)
            inside = value.startswith("#") and value[1:] in page.ids
            assert inside or value.startswith(("https://", "http://")), value
    assert "@import" not in text
    assert "url(" not in text
    return page


def test_the_page_is_whole_escaped_and_needs_nothing_else():
    text = html(TEXTS)
    page = check(text)
    assert (page.tags["table"], page.tags["img"], page.tags["section"]) == (1, 1, 2)
    assert "A &lt; B &amp; <em>C</em>: <code>a&lt;b</code>" in text
    assert '<a href="https://example.org/x?a=1&amp;b=2">the source</a>' in text
    assert "&lt;script&gt;" in text
    assert 'alt="What it &quot;shows&quot;"' in text
    assert '<td style="text-align:right">13.5</td>' in text
    assert text.count('<a href="#first">') == 2  # of the contents, and of the other page
    assert "First &lt;study&gt;</a>" in text
    assert (page.tags["h1"], page.tags["h2"], page.tags["h3"]) == (1, 2, 1)


def test_the_committed_page_is_that_of_the_committed_pages():
    texts = {
        path.name: path.read_text()
        for name in report.STUDIES
        for path in [*sorted(COMMITTED.glob("*.svg")), COMMITTED / f"{name}.md"]
    }
    text = (COMMITTED / report.PAGE).read_text()
    assert text == html(texts)
    page = check(text)
    assert page.tags["section"] == len(report.STUDIES)
    assert page.tags["img"] >= len(report.STUDIES)
    assert page.tags["table"] == sum(text.count("\n|--") for text in texts.values())


def test_without_markdown_it_a_report_says_so_before_its_work(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "markdown_it", None)
    monkeypatch.setattr(report, "_run", lambda *_: pytest.fail("a study was run"))
    assert main(["report", "-o", str(tmp_path / "out")]) == 2
    told = "report: markdown-it-py: expected it to be installed: pip install 'polhode[report]'"
    assert capsys.readouterr().err == f"polhode: {told}\n"
    assert not [*tmp_path.iterdir()]
