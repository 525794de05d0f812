"""What every proof is: a theorem with its certificate, or the reason why there is none."""

from __future__ import annotations

from pathlib import Path

from polhode.common.arguments import of_kind
from polhode.results.result import Result


class NotProved(ArithmeticError):
    """A claim that polhode did not prove: the first inequality that does not hold, what to try.

    >>> import polhode
    >>> polhode.prove_orbit("euler/largest-axis")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    polhode.proofs.theorem.NotProved: euler/largest-axis: the orbit is not isolated, ...
    """


class Theorem(Result):
    """A result with ``certificate``, the JSON text that ``polhode verify`` checks."""

    certificate: str

    def save(self, path: str | Path) -> None:
        """Write the theorem, or as .json its certificate, which ``polhode verify`` checks.

        Parameters
        ----------
        path : str or Path
            ``.json``: the certificate.  Other endings as of any result; those load again by
            :func:`polhode.load_result`.

        Raises
        ------
        BadInput
            A file that cannot be written.
        """
        of_kind("save", "path", path, (str, Path), "the path of a file")
        if Path(path).suffix.lower() not in (".json", ""):  # "-" is stdout
            super().save(path)
            return
        from polhode.certificates import certificate_file

        certificate_file.write(path, self.certificate)
