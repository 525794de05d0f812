"""``polhode show``: what a scene is."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.text_tables import one_line
from polhode.scenes import library
from polhode.verbs.options import word
from polhode.verbs.terminal import DONE, print_json, say

HELP = "body, regime, integrals, frequencies, columns to be integrated"
_BOOK = "Yehia, Rigid Body Dynamics: A Lagrangian Approach"
_IN_FULL = {"period": "period of omega"}  # in the body


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")


def main(options: Namespace) -> int:
    """Body, regime, integrals, frequencies, columns to be integrated."""
    from polhode.output.description import described

    facts = described(library.load(options.scene))
    if options.json:
        print_json(facts)
        return DONE
    for key, value in facts.items():
        if key == "source":
            value = f"{_BOOK}, {value}"
        elif isinstance(value, dict):
            told = {_IN_FULL.get(k, k): v for k, v in value.items() if v is not None}
            value = ", ".join(f"{k} = {v}" for k, v in told.items())
        elif isinstance(value, (tuple, list)):
            value = ", ".join(str(x) for x in value)
        if value not in (None, ""):
            say(f"{key:<14}{one_line(str(value))}")
    return DONE
