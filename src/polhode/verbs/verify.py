"""``polhode verify``: a certificate checked by a program that shares no code with the proof."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.terminal import DONE, FAILED, ProgressLine, print_json, say, word

HELP = "check a proof's certificate by code of its own"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "file", type=word, metavar="CERT.json", help="a certificate, or - for standard input"
    )


def main(options: Namespace) -> int:
    """Check one file: exit code 0 where it is proved, 1 where it is not."""
    from polhode.certificates.verdict import verify

    with ProgressLine("verify") as progress:
        found = verify(options.file, progress.show)
    if options.json:
        print_json({"file": options.file, "proved": found.proved, "text": found.text})
    else:
        say(found.text)
    return DONE if found.proved else FAILED
