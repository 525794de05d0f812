"""``polhode guide``: the guide that ships."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.terminal import DONE, print_json, say

HELP = "the guide: topics, or one of them"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("topic", nargs="?", default="index", metavar="TOPIC", help="see the list")


def main(options: Namespace) -> int:
    """Print a page of the guide, or the notebook."""
    from polhode.output import guide

    text = guide.notebook() if options.topic == guide.NOTEBOOK else guide.page(options.topic)
    if options.json:
        print_json({"topic": options.topic, "topics": guide.topics(), "text": text})
    else:
        say(text.rstrip())
    return DONE
