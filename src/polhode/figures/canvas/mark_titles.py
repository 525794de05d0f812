"""Titles of marks in SVG: what a reader sees who points at one, and a screen reader says."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

CLASS = "marks"  # of a group whose marks have titles
_MARK = re.compile(r"(<use [^>]*)/>")


def titled(svg: str, texts: Mapping[str, Sequence[str]]) -> str:
    """The SVG with a title in every mark of the groups with these identifiers.

    Raises ValueError where a group has another number of marks than texts.

    >>> titled('<g id="a"><use href="#m"/></g>', {"a": ["x < y"]})
    '<g class="marks"><use href="#m"><title>x &lt; y</title></use></g>'
    """
    parts = re.split(r"(?=<g id=\")", svg)
    return "".join(_titled(part, texts) for part in parts)


def _titled(part: str, texts: Mapping[str, Sequence[str]]) -> str:
    """One group up to the next one that has an identifier."""
    opening = re.match(r'<g id="([^"]+)">', part)
    if opening is None or opening[1] not in texts:
        return part
    told = texts[opening[1]]
    if len(_MARK.findall(part)) != len(told):
        raise ValueError(f"{len(_MARK.findall(part))} marks and {len(told)} texts: {told[:1]}")
    part = f'<g class="{CLASS}">{part[opening.end() :]}'
    left = iter(told)
    return _MARK.sub(lambda mark: f"{mark[1]}><title>{escape(next(left))}</title></use>", part)
