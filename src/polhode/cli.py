"""The command line: verbs, exit codes, what goes to which stream.

Results go to stdout, notes and progress to stderr.  Exit codes: 0 done, 1 a check failed, 2 bad
input, 3 the run could not reach its end, 130 interrupted.
"""

from __future__ import annotations

import argparse
import gc
import re
import signal
import sys
import threading
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any, NoReturn

from polhode.common.arguments import called_here
from polhode.common.errors import BadInput, StdoutFault, in_verb, listed, nearest
from polhode.common.files import write_stdout
from polhode.common.interrupts import INTERRUPTED, heard
from polhode.common.provenance import __version__
from polhode.verbs import catalogue, deliver, terminal
from polhode.verbs.terminal import BAD_INPUT, DONE

#: What other programs call a verb, and what is meant here.
_MEANT = {
    "help": "polhode --help, or polhode VERB --help; polhode guide explains everything",
    "version": "polhode --version, or polhode about",
    "info": "about for polhode, show SCENE for a scene",
    **dict.fromkeys(("integrate", "simulate", "solve", "propagate", "compute"), "run SCENE"),
    **dict.fromkeys(("judge", "validate", "diff", "score"), "compare FILE SCENE"),
    **dict.fromkeys(("test", "regression"), "check"),
    "enclose": "certify SCENE",
    **dict.fromkeys(("animate", "movie", "film"), "view SCENE -o x.html, or plot SCENE -o x.gif"),
    **dict.fromkeys(("figure", "draw", "graph"), "plot SCENE"),
    **dict.fromkeys(("ensemble", "scan", "vary"), "sweep SCENE --vary KEY=FROM:TO:N"),
    "poincare": "section SCENE",
    **dict.fromkeys(("lyapunov", "chaos"), "map SCENE, or sweep SCENE --keep lyapunov"),
    **dict.fromkeys(("docs", "doc", "manual"), "guide"),
    **dict.fromkeys(("cases", "ls"), "list"),
    **dict.fromkeys(("create", "init"), "new FILE"),
    "spectrum": "frequencies SCENE",
}

#: Where a mistake is that stands in no verb.
_NO_VERB = "command line"

#: What follows is a name, even if it looks like an option.
_BEFORE = "it after the verb and its options; what follows it is a name"

WELCOME = f"""\
polhode {__version__}: how a heavy rigid body moves about a fixed point, to how many correct digits.

Three commands to try:
  polhode list                                  the motions that ship
  polhode run kovalevskaya/generic --digits 30  one of them, to thirty digits that are checked
  polhode view lagrange/looping -o top.html     a page on which it moves

polhode guide explains everything, polhode --help lists the verbs.
"""


class _Parser(ArgumentParser):
    """argparse with the one-line errors of this program."""

    def error(self, message: str) -> NoReturn:
        verb = self.prog.removeprefix("polhode").strip()
        command = f"polhode {verb}" if verb else "polhode"
        source = command if verb else _NO_VERB
        if match := re.match(r"argument VERB: invalid choice: '(.*?)'", message):
            meant = _MEANT.get(match[1].lower())
            raise BadInput(source, "VERB", match[1], meant or listed(match[1], [*catalogue.NAMES]))
        if match := re.match(
            r"argument ([\w-]+): invalid choice: '(.*?)' \(choose from (.*)\)", message
        ):
            words = [word.strip(" '") for word in match[3].split(",")]
            raise BadInput(source, match[1], match[2], nearest(match[2], words))
        if match := re.match(r"argument ([^\s:]+): (.+), not '?(.*?)'?$", message):  # by a type
            raise BadInput(source, match[1], match[3], match[2])
        raise BadInput(source, "command", None, f"what {command} --help shows ({message})")

    def _print_message(self, message: str, file: object = None) -> None:
        """Help and version, as any other result: argparse would not say that they got lost."""
        write_stdout(message)

    def refuse(self, rest: Sequence[str], arguments: Sequence[str]) -> NoReturn:
        """Refuse unknown arguments, and suggest the closest known option."""
        source = _NO_VERB if self.prog == "polhode" else self.prog
        if "--" in arguments:
            raise BadInput(source, "argument", "--", _BEFORE)
        first = rest[0].partition("=")[0]
        options = self._option_string_actions
        long_options = [name for name in options if name.startswith("--")]
        if first.startswith("-"):
            name = first.lstrip("-").replace("-", "_")
            here = called_here(name, [option.lstrip("-") for option in options])
            dashes = "-" if here == "o" else "--"
            meant = None if here is None else f"{dashes}{here}, as it is called here"
            raise BadInput(source, "option", first, meant or nearest(first, long_options))
        raise BadInput(source, "argument", first, f"nothing more; see {self.prog} --help")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; the exit code.  A caller's handlers of signals are what they were before."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        return _main(arguments)
    finally:
        if arguments is not None and threading.current_thread() is threading.main_thread():
            for number, handler in handlers.items():
                if signal.getsignal(number) is heard:
                    signal.signal(number, handler)


def _main(arguments: Sequence[str] | None) -> int:
    try:
        try:
            terminal.prepare()
            words = sys.argv[1:] if arguments is None else [*arguments]
            if words[:1] == ["--print-completion"]:
                terminal.say(_completion(words[1:]))
                return DONE
            if not words:
                terminal.say(WELCOME.rstrip())
                return DONE
            if words[0] == "--":
                raise BadInput(_NO_VERB, "argument", "--", _BEFORE)
            parser = _parser(words)
            options, rest = parser.parse_known_args(_joined(words, parser))
            if rest:
                options.parser.refuse(rest, words)
            with in_verb():
                code: int = options.main(options)
            return code
        except BadInput as fault:
            if heard.came and isinstance(fault.__context__, ImportError):
                return _interrupted()
            terminal.note(f"polhode: {fault}")
            return BAD_INPUT
        except KeyboardInterrupt:
            return _interrupted()
        except Exception as fault:
            if heard.came:  # by a compiled library, which made another exception of it
                return _interrupted()
            if isinstance(fault, ModuleNotFoundError) and fault.name == "heyoka":
                terminal.note(f"polhode: {fault}")
                return BAD_INPUT
            raise
    except StdoutFault as full:
        terminal.give_up_stdout()
        if isinstance(full.fault, BrokenPipeError):  # the reader had enough
            return DONE
        terminal.note(f"polhode: cannot write to standard output: {full}")
        return BAD_INPUT
    except OSError as fault:
        where = fault.filename or "the system"
        terminal.note(f"polhode: {where}: expected to be usable ({fault.strerror})")
        return BAD_INPUT


def command() -> NoReturn:
    """The command ``polhode``: main, and out."""
    if 0 < sys.get_int_max_str_digits() < sys.int_info.default_max_str_digits:
        sys.set_int_max_str_digits(sys.int_info.default_max_str_digits)  # whatever is printed
    code = main()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # all is said: nothing is left to interrupt
    gc.freeze()  # what is left goes with the process: nobody need look for circles in it
    sys.exit(code)


def _interrupted() -> int:
    terminal.note("polhode: interrupted")
    return INTERRUPTED


def _completion(words: Sequence[str]) -> str:
    """A script that completes verbs and options in a shell."""
    try:
        import shtab
    except ImportError:
        expected = "shtab, which completion needs: pip install 'polhode[shell]'"
        raise BadInput(_NO_VERB, "--print-completion", None, expected) from None
    shells = list(shtab.SUPPORTED_SHELLS)
    if len(words) != 1 or words[0] not in shells:
        shell = words[0] if words else None
        raise BadInput(_NO_VERB, "--print-completion", shell, nearest(shell, shells))
    return str(shtab.complete(_parser((), whole=True), words[0])).rstrip()


def _joined(arguments: Sequence[str], parser: ArgumentParser) -> list[str]:
    """``--at -1,2`` as ``--at=-1,2``: argparse would take a negative number for an option."""
    options = dict(_options_of(parser))
    joined: list[str] = []
    pending = ""
    for argument in arguments:
        if pending and argument.partition("=")[0] in options:
            joined.append(pending)
            pending = ""
        if pending:
            # argparse drops a "--", wherever it stands, and would give no value at all
            joined += [pending, argument] if argument == "--" else [f"{pending}={argument}"]
            pending = ""
        elif options.get(argument, False) and argument.startswith("--"):
            pending = argument
        else:
            joined.append(argument)
    return [*joined, pending] if pending else joined


def _options_of(parser: ArgumentParser) -> Iterator[tuple[str, bool]]:
    """All options of a parser and of those below it, and whether each takes one value."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _options_of(below)
        for option in action.option_strings:
            yield option, action.nargs is None


def _parser(words: Sequence[str], whole: bool = False) -> ArgumentParser:
    """The parser of the verb that these arguments begin with, others by their names alone.

    ``whole``: with the options of all verbs.
    """
    top = _Parser(
        prog="polhode",
        description="Heavy rigid body about a fixed point: trajectories with proven digits.",
    )
    top.add_argument("--version", action="version", version=f"polhode {__version__}")
    kinds = top.add_subparsers(dest="verb", required=True, metavar="VERB", parser_class=_Parser)
    names = words[:1] if words[:1] and words[0] in catalogue.NAMES else catalogue.NAMES
    for name in names:
        in_full = whole or len(names) == 1
        if name in catalogue.VERBS:
            _add_row(kinds, catalogue.VERBS[name], name, in_full)
        else:
            about = catalogue.GROUPS[name]
            group = kinds.add_parser(name, help=about, description=about, allow_abbrev=False)
            below = group.add_subparsers(
                dest="claim", metavar="WHAT", required=True, parser_class=_Parser
            )
            for row in catalogue.ROWS:
                if row.name.startswith(f"{name} "):
                    _add_row(below, row, row.name.partition(" ")[2], in_full)
    return top


def _add_row(kinds: Any, row: catalogue.Verb, name: str, in_full: bool) -> None:
    added = kinds.add_parser(
        name,
        help=row.help,
        description=row.help,
        epilog=f"example:\n  {row.command}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    if in_full:
        if row.kind:
            deliver.add_options(added, row)
        else:
            module = import_module(row.home)
            getattr(module, f"add_{row.function}")(added)
            added.set_defaults(main=getattr(module, row.function))
        added.add_argument("--json", action="store_true", help="the result as JSON on stdout")
        added.set_defaults(parser=added)


if __name__ == "__main__":
    command()
