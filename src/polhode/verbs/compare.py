"""``polhode compare``: judge a trajectory that some other program computed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.output import results
from polhode.verbs.terminal import DONE, print_json, say, whole

HELP = "judge a trajectory that some other program computed"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("file", metavar="FILE", help="a CSV with a column t and any of the others")
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--number", help="the file's decimals are rounded values of this type")
    parser.add_argument("--digits", type=whole, help="digits of mp, with --number mp")


def main(options: Namespace) -> int:
    """Judge a trajectory that some other program computed."""
    from polhode.judging.judgement import compare

    path, number, digits = Path(options.file), options.number, options.digits
    judged = compare(path, options.scene, number=number, digits=digits)
    if options.json:
        print_json(results.of_judgement(judged))
    else:
        say(str(judged))
    return DONE
