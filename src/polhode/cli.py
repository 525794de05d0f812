"""The command line: verbs, exit codes, what goes to which stream.

Results go to stdout, notes and progress to stderr.  Exit codes: 0 done, 1 a check failed, 2 bad
input, 3 the run could not reach its end, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from polhode.errors import BadInput

DONE, FAILED, BAD_INPUT, NOT_REACHED, INTERRUPTED = 0, 1, 2, 3, 130


class _Parser(argparse.ArgumentParser):
    """argparse with the one-line errors of this program."""

    def error(self, message: str) -> NoReturn:
        verb = self.prog.removeprefix("polhode").strip()
        command = f"polhode {verb}" if verb else "polhode"
        raise BadInput(command, "command", None, f"what {command} --help shows ({message})")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; the exit code."""
    try:
        try:
            given = sys.argv[1:] if arguments is None else arguments
            options = _parser().parse_args(_joined(given))
            from polhode import verbs

            code: int = getattr(verbs, options.verb)(options)
            sys.stdout.flush()
            return code
        except BadInput as fault:
            print(f"polhode: {fault}", file=sys.stderr)
            return BAD_INPUT
        except KeyboardInterrupt:
            print("polhode: interrupted", file=sys.stderr)
            return INTERRUPTED
    except OSError as fault:  # stdout takes no more: what is left in its buffer goes nowhere
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(fault, BrokenPipeError):  # the reader had enough
            return DONE
        print(f"polhode: stdout: expected a place to write to ({fault.strerror})", file=sys.stderr)
        return BAD_INPUT


def _joined(arguments: Sequence[str]) -> list[str]:
    """``--at -1,2`` as ``--at=-1,2``: argparse would take a negative time for an option."""
    joined: list[str] = []
    pending = ""
    for argument in arguments:
        if pending:
            joined.append(f"{pending}={argument}")
            pending = ""
        elif argument in ("--at", "--tol"):
            pending = argument
        else:
            joined.append(argument)
    return [*joined, pending] if pending else joined


def _parser() -> argparse.ArgumentParser:
    top = _Parser(
        prog="polhode",
        description="Heavy rigid body about a fixed point: trajectories with proven digits.",
    )
    verbs = top.add_subparsers(dest="verb", required=True, metavar="VERB", parser_class=_Parser)

    def verb(name: str, text: str) -> argparse.ArgumentParser:
        added = verbs.add_parser(name, help=text, description=text, allow_abbrev=False)
        added.add_argument("--json", action="store_true", help="results as JSON on stdout")
        return added

    listing = verb("list", "the cases that ship, with regime and reference")
    listing.add_argument("--tag", help="only the cases with this tag")

    show = verb("show", "body, regime, integrals, frequencies, what will be modelled")
    show.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")

    run = verb("run", "integrate a scene")
    run.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    run.add_argument("--digits", type=_digits, help="digits wanted; they choose the number type")
    run.add_argument("--number", help="double (default), extended, quad or mp")
    run.add_argument("--at", metavar="T,T...", help="output times instead of the scene's")
    run.add_argument("--tol", metavar="X", help="tolerance of a step, the type's eps unless given")
    run.add_argument("--form", metavar="F", help="form of the equations")
    run.add_argument("--outputs", metavar="O,O", help="angles, attitude: instead of the scene's")
    run.add_argument("--max-steps", type=_steps, metavar="N", help="limit on the steps")
    run.add_argument("--no-project", action="store_true", help="no projection (there is none yet)")
    run.add_argument("-o", dest="file", metavar="FILE", help="write a CSV, and JSON beside it")

    reference = verb("reference", "the closed form alone, no integration")
    reference.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    reference.add_argument("--at", metavar="T,T...", help="times instead of the scene's")
    reference.add_argument("--digits", type=_digits, default=50, help="correct digits (50)")

    check = verb("check", "regression against references and published figures")
    check.add_argument("scenes", nargs="*", metavar="SCENE", help="names, patterns or paths")
    check.add_argument("--number", action="append", help="this number type instead of the case's")

    compare = verb("compare", "judge a trajectory that some other program computed")
    compare.add_argument("file", metavar="FILE", help="a CSV with a column t and any of the others")
    compare.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    compare.add_argument("--number", help="the file's decimals are rounded values of this type")
    compare.add_argument("--digits", type=_digits, help="digits of mp, with --number mp")

    report = verb("report", "run the studies and write them as JSON and Markdown")
    report.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    report.add_argument("-o", dest="folder", metavar="DIR", default="reports", help="where to")

    verb("about", "versions, number types, processor, caches")
    return top


def _digits(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"a whole number, not {text[:40]!r}") from None


def _steps(text: str) -> int:
    steps = _digits(text)
    if steps < 1:
        raise argparse.ArgumentTypeError(f"1 or more, not {steps}")
    return steps


if __name__ == "__main__":
    sys.exit(main())
