"""``polhode list``: the cases that ship."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput, listed
from polhode.scenes import library
from polhode.verbs.terminal import DONE, print_json, print_table

HELP = "the cases that ship, with regime and reference"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--tag", help="only the cases with this tag")


def main(options: Namespace) -> int:
    """The cases that ship."""
    from polhode.judging.references.reference import reference as reference_of

    rows = []
    scenes = {name: library.load(name) for name in library.names()}
    known = sorted({tag for scene in scenes.values() for tag in scene.tags})
    if options.tag is not None and options.tag not in known:
        raise BadInput(
            "list", "--tag", options.tag, f"one of the tags {listed(options.tag, known)}"
        )
    for name, scene in scenes.items():
        if options.tag and options.tag not in scene.tags:
            continue
        reference = reference_of(scene)
        rows.append(
            {
                "name": name,
                "title": scene.title,
                "tags": [*scene.tags],
                "regime": reference.regime,
                "reference": reference.kind,
            }
        )
    if options.json:
        print_json(rows)
    else:
        table = [[r["name"], r["reference"], r["regime"], r["title"]] for r in rows]
        print_table(["case", "reference", "regime", "title"], table)
    return DONE
