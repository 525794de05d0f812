"""Whether a certificate proves what it states."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from polhode.certificates import verify as checker
from polhode.common.arguments import of_kind, with_progress
from polhode.common.errors import BadInput
from polhode.common.files import read_stdin, read_whole
from polhode.common.interrupts import Progress
from polhode.numbers.flint_context import ctx
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table


@dataclass(frozen=True, repr=False)
class Verdict(Result):
    """The result of checking a certificate; true if it is proved.

    Attributes
    ----------
    proved : bool
        Whether every inequality of the proof holds.
    text : str
        What is proved; or the first inequality that does not hold.

    Examples
    --------
    >>> import polhode
    >>> bool(polhode.Verdict(False, "not proved: the condition of the step"))
    False
    """

    proved: bool
    text: str

    def __bool__(self) -> bool:
        return self.proved

    @property
    def passed(self) -> bool:
        """Whether it is proved."""
        return self.proved

    def table(self) -> Table:
        """One row per line of the text."""
        lines = self.text.splitlines()
        return Table([Column("line", [*range(1, len(lines) + 1)]), Column("statement", lines)])

    def facts(self) -> list[Fact]:
        """Whether it is proved, and on what that rests."""
        return [Fact("proven", self.proved), Fact("rests_on", trusted_base())]

    def __repr__(self) -> str:
        return f"<Verdict: {'proved' if self.proved else 'not proved'}>"

    def __str__(self) -> str:
        return self.text


def trusted_base() -> str:
    """What a proved certificate rests on, in a sentence.

    >>> trusted_base().startswith("This rests on certificates/verify.py, ")
    True
    """
    lines = len(Path(checker.__file__).read_text(encoding="utf-8").splitlines())
    return (
        f"This rests on certificates/verify.py, {lines} lines that import nothing of polhode, on "
        "FLINT through python-flint, and on Python."
    )


@with_progress
def verify(path: str | Path, progress: Progress | None = None) -> Verdict:
    """Check a certificate.

    The checker is one file, ``polhode/certificates/verify.py``, which imports nothing of polhode,
    only python-flint and the standard library: ``python verify.py CERT.json`` does the same.

    Parameters
    ----------
    path : str or Path
        A file that ``save`` of an enclosure, a proved orbit or proved chaos wrote, or ``-o`` of
        ``polhode certify`` or ``polhode prove``; ``-`` is the standard input.
    progress : callable, optional
        Called with the fraction of the steps done, and how many.

    Returns
    -------
    Verdict
        Whether it is proved, and what.

    Raises
    ------
    BadInput
        A file that is no certificate, with the reason.

    Examples
    --------
    >>> import polhode, tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "proof.json"
    >>> polhode.certify("general/asymmetric-regular", at=[1], digits=16).save(file)
    >>> polhode.verify(file).proved
    True
    """
    of_kind("verify", "path", path, (str, Path), "the path of a certificate")
    most, expected = checker.LARGEST, "a readable certificate"
    data = (
        read_stdin(most, expected) if str(path) == "-" else read_whole(Path(path), most, expected)
    )
    try:
        with ctx.workprec(checker.COARSE):  # which the checker changes as it likes
            return Verdict(True, "\n".join(checker.verify(data, progress)))
    except checker.NotProved as fault:
        return Verdict(False, f"not proved: {fault}")
    except checker.Damaged as fault:
        raise BadInput(str(path), "certificate", None, f"one of polhode's ({fault})") from None
