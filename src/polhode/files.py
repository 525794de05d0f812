"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from polhode.errors import BadInput


def write_whole(path: Path, text: str) -> None:
    """Write a text file through a temporary one beside it, then rename; raises BadInput."""
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as out:
            out.write(text)
            out.flush()
            os.fsync(out.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
        temporary = None
    except OSError as error:
        raise BadInput(str(path), "file", None, f"a place to write to ({error.strerror})") from None
    finally:
        if temporary is not None:
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
