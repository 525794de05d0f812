"""``polhode guide``: the guide that ships."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.terminal import DONE, print_json, say

_MOST = 12  # places of a word that are shown


def add_guide(parser: ArgumentParser) -> None:
    """The verb's own options."""
    topic = "a page of the list; or words to search for"
    parser.add_argument("topic", nargs="*", default=["index"], metavar="TOPIC", help=topic)


def guide(options: Namespace) -> int:
    """Print a page of the guide, the notebook, or where words stand."""
    from polhode.output import guide

    topic, *more = options.topic
    if topic == guide.NOTEBOOK and not more:
        text = guide.notebook()
    elif not more and topic in [guide.INDEX, *guide.topics()]:
        text = guide.page(topic)
    else:
        text = _places(" ".join(options.topic))
    if options.json:
        answer = {"topic": " ".join(options.topic), "topics": guide.topics(), "text": text}
        print_json(answer)
    else:
        say(text.rstrip())
    return DONE


def _places(words: str) -> str:
    """Where the words stand; raises BadInput where they stand nowhere."""
    from polhode.output import guide

    places = guide.search(words)
    if not places:
        guide.page(words)  # refused, with the nearest topic
    shown = [
        f"polhode guide {topic}  ({heading})\n    {text}" for topic, heading, text in places[:_MOST]
    ]
    rest = len(places) - len(shown)
    return "\n".join([*shown, *[f"({rest} more places)"] * bool(rest)])
