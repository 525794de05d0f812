"""``polhode guide``: the guide that ships."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.terminal import DONE, print_json, say

HELP = "the guide: topics, one of them, a public name of the package, or where a word occurs"

_MOST = 12  # places of a word that are shown


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "topic",
        nargs="*",
        default=["index"],
        metavar="TOPIC",
        help="a page of the list; api NAME for a public name; or words to search for",
    )


def main(options: Namespace) -> int:
    """Print a page of the guide, the notebook, the reference of a name, or where words stand."""
    from polhode.output import api_reference, guide

    topic, *more = options.topic
    if topic == guide.NOTEBOOK and not more:
        text = guide.notebook()
    elif topic == "api":
        text = api_reference.page(".".join(more).removeprefix("polhode.")) if more else _names()
    elif not more and topic in [guide.INDEX, *guide.topics()]:
        text = guide.page(topic)
    else:
        text = _found(" ".join(options.topic))
    if options.json:
        told = {"topic": " ".join(options.topic), "topics": guide.topics(), "text": text}
        print_json(told)
    else:
        say(text.rstrip())
    return DONE


def _names() -> str:
    """The list of public names."""
    from polhode.output import api_reference

    lines = ["# The public names", "", "`polhode guide api NAME` describes one.", ""]
    return "\n".join([*lines, *api_reference.table()])


def _found(words: str) -> str:
    """Where the words stand; raises BadInput where they stand nowhere."""
    from polhode.output import guide

    found = guide.search(words)
    if not found:
        guide.page(words)  # refused, with the nearest topic
    shown = [
        f"polhode guide {topic}  ({heading})\n    {text}" for topic, heading, text in found[:_MOST]
    ]
    rest = len(found) - len(shown)
    return "\n".join([*shown, *[f"({rest} more places)"] * bool(rest)])
