"""``polhode list``: the cases that ship."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput, listed
from polhode.scenes import catalogue, library
from polhode.verbs.terminal import DONE, print_json, print_table

HELP = "the cases that ship, with regime and reference"

_KEYS = ("name", "title", "tags", "regime", "reference")


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--tag", help="only the cases with this tag")


def main(options: Namespace) -> int:
    """The cases that ship."""
    found = entries()
    tags = sorted({tag for entry in found.values() for tag in entry.tags})
    if options.tag is not None and options.tag not in tags:
        expected = f"one of the tags {listed(options.tag, tags)}"
        raise BadInput("list", "--tag", options.tag, expected)
    shown = {
        name: entry for name, entry in found.items() if not options.tag or options.tag in entry.tags
    }
    if options.json:
        rows = [{"name": k, **x._asdict(), "tags": [*x.tags]} for k, x in shown.items()]
        print_json([{key: row[key] for key in _KEYS} for row in rows])
    else:
        table = [[k, x.reference, x.regime, x.title] for k, x in shown.items()]
        print_table(["case", "reference", "regime", "title"], table)
    return DONE


def entries() -> dict[str, catalogue.Entry]:
    """What is listed of each case: from the catalogue, or found now for a file not in it."""
    known = catalogue.known()
    return {name: known.get(name) or entry_of(name) for name in library.names()}


def entry_of(name: str) -> catalogue.Entry:
    """What is listed of a case, from its file."""
    from polhode.judging.references.reference import reference as reference_of

    scene = library.load(name)
    reference = reference_of(scene)
    return catalogue.Entry(scene.title, scene.tags, reference.regime, reference.kind)
