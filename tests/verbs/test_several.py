"""Several files of one command, several motions on one page."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import unescape
from pathlib import Path

import pytest

import polhode
from polhode import Result
from polhode.cli import main
from polhode.common.errors import counted
from polhode.common.interrupts import ProgressLine
from polhode.results.table import Fact, Table
from polhode.verbs.catalogue import Verb
from polhode.verbs.deliver import Places


class Own(Result):
    """A result with a file of its own, and no figure."""

    def save(self, path: str | Path) -> None:
        """Write that file."""
        Path(path).write_text("own")

    def table(self) -> Table:
        """No columns."""
        return Table([], 0)

    def facts(self) -> Sequence[Fact]:
        """None."""
        return [Fact("scene", counted(1, "thing"))]


@pytest.mark.parametrize("names", [["x.own", "x.svg"], ["x.npz", "x.own", "x.svg"]])
def test_where_a_figure_fails_nothing_is_written(names, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    verb = Verb("own", "", "", "Own", "", "", own=(".own",))
    places = Places(verb, [*map(Path, names)], False, [])
    with pytest.raises(polhode.BadInput, match="result = Own: expected one that has a figure"):
        places.write(Own(), {}, ProgressLine("own"))
    assert not [*tmp_path.iterdir()]
    places = Places(verb, [*map(Path, names[:-1])], False, [])
    places.write(Own(), {}, ProgressLine("own"))
    assert {x.name for x in tmp_path.iterdir()} == {*names[:-1]}


def framed(text: str) -> list[str]:
    """The pages in the frames of one."""
    return [unescape(x) for x in re.findall(r'srcdoc="([^"]*)"', text)]


def test_a_page_of_several_motions_has_each_one_s_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = "One & two.\n\nThree <four>.\n"
    polhode.integrate("lagrange/looping", at=[0, 1]).save("run.csv")
    tops = ["euler/dzhanibekov", "run.csv"]
    for top in tops:
        assert main(["view", top, "--end", "1", "-o", f"{top[:5]}.html".replace("/", "")]) == 0
    command = ["view", *tops, "--end", "1", "--title", "A <lesson>", "--text", words]
    assert main([*command, "-o", "x.html"]) == 0
    text = Path("x.html").read_text()
    assert "<h1>A &lt;lesson&gt;</h1>" in text
    assert "<p>One &amp; two.</p>\n<p>Three &lt;four&gt;.</p>" in text
    assert text.endswith("</html>\n")
    assert 'document.addEventListener("load"' in text  # the load of a frame reaches no window
    assert "new ResizeObserver(fit)" in text  # a frame was 46rem high, with a scrollbar of its own
    pages = framed(text)
    for page, top in zip(pages, tops, strict=True):
        alone = Path(f"{top[:5]}.html".replace("/", "")).read_text()
        command = re.compile(r"<code>polhode view [^<]*</code>")
        assert command.sub("", page) == command.sub("", alone)
    inside = polhode.view(*tops, end=1, title="A <lesson>", text=words)
    assert [len(x) for x in framed(inside.text)] == pytest.approx([len(x) for x in pages], abs=90)
    assert inside.name == "A <lesson>"
