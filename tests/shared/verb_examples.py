"""The examples of all verbs, which --help prints, and the files that they read."""

from __future__ import annotations

import shlex
from pathlib import Path

import polhode
from polhode.cli import main
from polhode.verbs.catalogue import ROWS, VERBS, Verb

TOP = "lagrange/nutation"
EXAMPLES = {verb.name: verb.command.removeprefix("polhode ") for verb in ROWS}


def verb_of(command: str) -> Verb:
    """The row of a command's verb, of two words if there is one."""
    first, second = f"{command} ".split(" ")[:2]
    return VERBS.get(f"{first} {second}") or VERBS[first]


def without_files(command: str) -> str:
    """A command without its -o."""
    return command.partition(" -o ")[0]


def prepare(command: str) -> None:
    """Make the files that a command reads, in the current folder: those that other examples write,
    and two tables of another program."""
    words = shlex.split(without_files(command))
    for verb in ("new", "run", "certify"):
        *_, name = shlex.split(EXAMPLES[verb]) if verb != "new" else [EXAMPLES[verb].split()[1]]
        if name in words and verb_of(command).name != verb and not Path(name).exists():
            prepare(EXAMPLES[verb])
            assert main(shlex.split(EXAMPLES[verb])) == 0
    for name, digits in (("coarse.csv", 3), ("fine.csv", 5)):
        if name in words:
            run = polhode.integrate(TOP, at=[1, 2, 3])
            cells = [[repr(float(x) + 10.0**-digits) for x in row] for row in run.states]
            rows = [f"{t},{','.join(row)}" for t, row in zip("123", cells, strict=True)]
            Path(name).write_text("\n".join(["t,p,q,r,gamma1,gamma2,gamma3", *rows, ""]))
