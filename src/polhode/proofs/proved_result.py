"""What every proof with a certificate does: it is saved as a result, or as its certificate."""

from __future__ import annotations

from pathlib import Path

from polhode.certificates import certificate_file
from polhode.results.result import Result


class ProvedResult(Result):
    """A theorem with ``certificate``, the JSON text that ``polhode verify`` checks."""

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
        if Path(path).suffix.lower() not in (".json", ""):  # "-" is stdout
            super().save(path)
            return
        certificate_file.write(path, self.certificate)
