"""``polhode view``: a motion, or several, as one page that moves."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.common.errors import BadInput
from polhode.verbs import plot
from polhode.verbs.options import word

HELP = "motions as one animated HTML page that needs nothing else"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    plot.source_options(parser, "sources", "+")
    parser.add_argument(
        "-o", dest="file", type=word, required=True, metavar="FILE", help="the page: .html"
    )
    parser.add_argument("--title", metavar="TEXT", help="a heading above the motions")
    text = "words above them: a text, with empty lines between paragraphs"
    parser.add_argument("--text", type=word, metavar="FILE", help=text)
    parser.set_defaults(what="motion", size=None, fps=None)


def main(options: Namespace) -> int:
    """Make one page."""
    suffix = Path(options.file).suffix.lower()
    if suffix in (*plot.FILMS, *plot.PRINTED):
        what = "motion" if suffix in plot.FILMS else "W"
        meant = f"polhode plot {options.sources[0]} --what {what} -o {options.file}"
        raise BadInput(options.file, "-o", None, f"a name that ends in .html, or {meant}")
    return plot.make(options, (plot.PAGE,))
