"""The line of progress on a terminal as narrow as it may be."""

from __future__ import annotations

import fcntl
import os
import pty
import struct
import sys
import termios

import pytest

from polhode.common.interrupts import ProgressLine


@pytest.fixture
def terminal(monkeypatch):
    """A terminal in place of stderr: sets its width, and gives what was written to it."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w", buffering=1) as stream:

        class Terminal:
            def shown(self) -> None:
                """In the test itself: pytest sets its own stderr before."""
                monkeypatch.setattr(sys, "stderr", stream)

            def wide(self, columns: int) -> None:
                fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))

            def written(self) -> str:
                stream.write("END")
                stream.flush()
                text = ""
                while "END" not in text:  # it comes in pieces
                    text += os.read(ours, 1 << 16).decode()
                return text.removesuffix("END")

        yield Terminal()
    os.close(ours)


@pytest.mark.parametrize("columns", [40, 80, 0])
def test_the_line_never_wraps(terminal, columns):
    """What wraps is not wiped: only the last of its lines would be."""
    terminal.shown()
    terminal.wide(columns)
    with ProgressLine("compare") as progress:
        progress.began -= 10
        progress.say("rows of the reference")
        progress.show(0.125, 10800, "rows of the closed form")
        progress.say("x" * 300)
    *lines, rest = terminal.written().split("\r\x1b[K")[1:]
    assert rest == ""
    assert [len(line) < (columns or 80) for line in lines] == [True] * 3
    assert lines[1].startswith("compare: 12.5 %, 10800 rows")
    assert len(lines[2]) == (columns or 80) - 1


def test_nothing_is_shown_of_what_takes_no_time(terminal):
    terminal.shown()
    with ProgressLine("compare") as progress:
        progress.began += 3600
        progress.say("quick")
    sys.stderr.write("end")
    assert terminal.written() == "end"
