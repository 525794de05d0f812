"""All pages as one HTML page that needs nothing else: Markdown in a template, figures inside."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput

if TYPE_CHECKING:
    from markdown_it import MarkdownIt


def require() -> None:
    """Raise BadInput where markdown-it-py is missing: before the studies run, not after."""
    _parser()


def html(texts: Mapping[str, str]) -> str:
    """The pages among the texts as one, with the figures among them; texts by names of files."""
    markdown = _parser()
    pages = {name.removesuffix(".md"): texts[name] for name in texts if name.endswith(".md")}
    contents, sections = [], []
    for name, text in pages.items():
        tokens = markdown.parse(text)
        for token in tokens:
            if token.type in ("heading_open", "heading_close"):  # the whole page has the first
                token.tag = f"h{int(token.tag[1:]) + 1}"
        title = escape(text.partition("\n")[0].removeprefix("# "))
        contents.append(f'<li><a href="#{name}">{title}</a></li>')
        made = markdown.renderer.render(tokens, markdown.options, {})
        sections.append(f'<section id="{name}">\n{made}</section>')
    page = (files(__package__) / "page.html").read_text(encoding="utf-8")
    whole = Template(page).substitute(contents="\n".join(contents), pages="\n".join(sections))
    for name in pages:
        whole = whole.replace(f'href="{name}.md"', f'href="#{name}"')
    for name, text in texts.items():
        inside = f"data:image/svg+xml;base64,{b64encode(text.encode()).decode()}"
        whole = whole.replace(f'src="{name}"', f'src="{inside}"')
    return whole


def _parser() -> MarkdownIt:
    try:
        from markdown_it import MarkdownIt
    except ImportError:
        expected = "it to be installed: pip install 'polhode[report]'"
        raise BadInput("study", "markdown-it-py", None, expected) from None
    return MarkdownIt("commonmark", {"html": False}).enable("table")
