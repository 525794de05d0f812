"""The guide that ships: pages of Markdown, with tables made of what the program itself goes by."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path

from polhode.common.errors import BadInput, listed
from polhode.numbers.expression import UNITS, named
from polhode.scenes import vocabulary
from polhode.scenes.vocabulary import COLUMNS

FOLDER = Path(__file__).parents[1] / "guide"
INDEX = "index"
NOTEBOOK = "notebook"
_AROUND = 50  # letters before a word that is shown, and half of those after it


def topics() -> list[str]:
    """The pages there are, in the order of the index."""
    there = {path.stem for path in FOLDER.glob("*.md")}
    listed = re.findall(r"^\| `polhode guide ([\w-]+)`", page(INDEX), re.M)
    return [*listed, *sorted(there - {*listed, INDEX})]


def page(topic: str) -> str:
    """A page as Markdown; raises BadInput for a topic that there is not."""
    if topic != INDEX and topic not in topics():
        raise BadInput("guide", "TOPIC", topic, listed(topic, [*topics(), NOTEBOOK]))
    text = (FOLDER / f"{topic}.md").read_text(encoding="utf-8")
    text = re.sub(r"\[([^\]]+)\]\(glossary\.md[^)]*\)", r"\1", text)  # no links on a terminal
    text = re.sub(r"<!-- keys ?([\w.]*) -->", lambda match: "\n".join(_keys(match[1])), text)
    text = re.sub(r"<!-- columns -->", lambda _: "\n".join(_columns()), text)
    text = re.sub(r"<!-- units -->", lambda _: "\n".join(_units()), text)
    return re.sub(r"<!-- api -->", lambda _: "\n".join(_names()), text)


def _columns() -> list[str]:
    """The outputs of a run as a table."""
    lines = ["| output | columns | |", "|---|---|---|"]
    for word, column in COLUMNS.items():
        lines.append(f"| `{word}` | `{' '.join(column.names)}` | {column.meaning} |")
    return lines


def _units() -> list[str]:
    """The units that numbers may have, by dimension."""
    by_dimension: dict[str, list[str]] = {}
    for name, unit in UNITS.items():
        by_dimension.setdefault(named(unit.dimension), []).append(f"`{name}`")
    lines = ["| in SI | units |", "|---|---|"]
    return [*lines, *(f"| `{k}` | {' '.join(names)} |" for k, names in by_dimension.items())]


def _names() -> list[str]:
    """Every public name, functions before classes, with the first sentence of its documentation."""
    package = import_module("polhode")
    public = (name for name in package.__all__ if not name.startswith("_"))
    lines = ["| name | |", "|---|---|"]
    for name in sorted(public, key=lambda name: (name[0].isupper(), name)):
        thing = getattr(package, name)
        about = (inspect.getdoc(thing) or "").split("\n\n")[0]
        sentence = re.split(r"(?<=[.;])\s", " ".join(about.split()))[0].rstrip(".;")
        plain = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", sentence.replace("``", "`"))
        lines.append(f"| `polhode.{name}{'' if inspect.isclass(thing) else '()'}` | {plain} |")
    return lines


def _keys(section: str) -> list[str]:
    """The keys of a section as a table, from the one that the reader of scenes goes by."""
    lines = ["| key | what | kind | default | example |", "|---|---|---|---|---|"]
    for key in vocabulary.KEYS[section]:
        default = f"`{key.default}`" if key.default else ""
        example = f"`{key.name} = {key.example}`" if key.example else ""
        kind = f"{key.kind}, {key.unit}" if key.unit else key.kind
        cells = (f"`{key.name}`", key.meaning, kind.replace("**", "^"), default, example)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines


def search(words: str) -> list[tuple[str, str, str]]:
    """Where all the words stand in one paragraph or row of a table: page, heading, the text there.

    Whole words in any case; a plural finds its singular and the other way round.  What stands
    under a heading of these words comes first: the glossary's entry, the section about it.
    """
    stems = [re.escape(word.removesuffix("s")) for word in words.split()]
    patterns = [re.compile(rf"\b{stem}s?\b", re.I) for stem in stems]
    titled: list[tuple[str, str, str]] = []
    others: list[tuple[str, str, str]] = []
    for topic in [INDEX, *topics()]:
        heading = topic
        joined = re.sub(r"^(#+ .*)\n\s*\n", r"\1\n", page(topic), flags=re.M)
        for paragraph in re.split(r"\n\s*\n|\n(?=\|)", joined):
            head = re.match(r"#+ (.*)\n?", paragraph)
            text = paragraph if head is None else paragraph[head.end() :]
            heading = heading if head is None else head[1]
            if head is not None and _first(patterns, heading) is not None:
                titled.append((topic, heading, _about(text, 0)))
            elif (place := _first(patterns, text)) is not None:
                others.append((topic, heading, _about(text, place)))
    return titled + others


def _first(patterns: list[re.Pattern[str]], text: str) -> int | None:
    """Where the first pattern stands in a text that all of them are in; else None."""
    places = [pattern.search(text) for pattern in patterns]
    if not places or None in places or places[0] is None:
        return None
    return places[0].start()


def _about(paragraph: str, place: int) -> str:
    """What stands around a place, cut between words."""
    before = re.sub(r"\s+", " ", paragraph[:place]).lstrip()
    after = re.sub(r"\s+", " ", paragraph[place:]).strip()
    if len(before) > _AROUND:
        before = "…" + before[-_AROUND:].partition(" ")[2]
    if len(after) > 2 * _AROUND:
        after = after[: 2 * _AROUND].rpartition(" ")[0] + "…"
    return before + after


def notebook() -> str:
    """A Jupyter notebook to begin with."""
    return (FOLDER / "first.ipynb").read_text(encoding="utf-8")
