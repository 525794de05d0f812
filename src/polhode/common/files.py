"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from polhode.common.errors import BadInput


def write_whole(texts: Mapping[Path, str | bytes]) -> None:
    """Write files, text or bytes, that belong together; raises BadInput.

    Each goes to a temporary file beside its place first; they are renamed once all are complete.
    """
    staged: dict[Path, str] = {}
    path = Path()
    try:
        for path, text in texts.items():
            handle, staged[path] = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
            with os.fdopen(handle, "wb") as out:
                out.write(text.encode() if isinstance(text, str) else text)
                out.flush()
                os.fsync(out.fileno())
            os.chmod(staged[path], 0o666 & ~_umask())
        for path in texts:
            os.replace(staged[path], path)
            del staged[path]
    except OSError as error:
        raise BadInput(str(path), "file", None, f"a place to write to ({error.strerror})") from None
    finally:
        for temporary in staged.values():
            Path(temporary).unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Refuse, before any work is done, a path that cannot be written; raises BadInput."""
    if path.is_dir():
        raise BadInput(str(path), "file", None, "a file, not a folder")
    if not path.parent.is_dir():
        raise BadInput(str(path), "file", None, f"an existing folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise BadInput(str(path), "file", None, "a folder that can be written to")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
