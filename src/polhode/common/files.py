"""How files are read and written: inputs whole and within a limit, outputs whole or not at all.

Output goes to a temporary file beside its place, which is then renamed.  Links are followed, an
input is never replaced, and what is no regular file (``-``, a FIFO, a device) is written to as a
stream and stays what it is.
"""

from __future__ import annotations

import errno
import io
import math
import os
import secrets
import select
import stat
import sys
import time
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from polhode.common.errors import BadInput, FileName, StdoutFault
from polhode.common.interrupts import Delay

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

STDOUT = Path("-")
STDIN = "standard input"  # what it is called
_HANDLES = ("/dev/fd/", "/proc/self/fd/")  # names of what is open already
MOST_UNPACKED = 1 << 32  # bytes of an NPZ file's arrays
MOST_ARRAYS = 10_000
SMALL, RATIO = 1 << 28, 200  # bytes that any NPZ file may unpack to; and per byte of a larger one
FEW_TEXTS, TEXTS = 100_000, 20  # elements of text, each of which is read; and per byte of a file
PATIENCE = 10.0  # seconds to wait for the first byte of a pipe
#: How files begin that polhode writes and that are no results: reports, starts of orbits.
_BEGINNINGS = {
    ".md": b"# Accuracy report\n",
    ".toml": b'schema = 1\ntitle = "A periodic orbit near ',
}


def read_whole(path: Path, most: int, expected: str, name: str | None = None) -> bytes:
    """The bytes of a file, a pipe or a device; raises BadInput for more than ``most`` of them.

    ``expected``: such as "a readable scene file".  ``name``: what to call the file.
    """
    name = name or str(path)
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return _streamed(file.fileno(), most, name, expected)
            return _bytes_within(file.read(most + 1), most, name)
    except (OSError, ValueError) as error:
        if isinstance(error, BadInput):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise BadInput(name, "file", None, f"{expected} ({reason})") from None


def read_stdin(most: int, expected: str) -> bytes:
    """What comes on the standard input until it ends, however slowly; raises BadInput for more than
    ``most`` bytes.  ``expected``: as of :func:`read_whole`."""
    try:
        with open(0, "rb", closefd=False) as file:
            return _bytes_within(file.read(most + 1), most, STDIN)
    except OSError as error:
        raise BadInput(STDIN, "file", None, f"{expected} ({error.strerror})") from None


def _bytes_within(data: bytes, most: int, name: str) -> bytes:
    """The same bytes; raises BadInput where they are more than so many."""
    if len(data) > most:
        raise BadInput(name, "file", None, f"at most {most} bytes")
    return data


def _streamed(handle: int, most: int, name: str, expected: str) -> bytes:
    """What a pipe or a device gives until it ends; refused where nothing comes at all."""
    parts: list[bytes] = []
    size = 0
    since = time.monotonic()
    pipe = stat.S_ISFIFO(os.fstat(handle).st_mode)
    while size <= most:
        left = since + PATIENCE - time.monotonic()
        ready, _, _ = select.select([handle], [], [], max(0.0, left))
        part = os.read(handle, 1 << 20) if ready else b""
        if not part and left <= 0:
            expected += f" (nothing came for {PATIENCE:g} seconds)"
            raise BadInput(name, "file", None, expected)
        if not part and (parts or not pipe):
            return b"".join(parts)
        if part:
            parts.append(part)
            size += len(part)
            since = time.monotonic()
        else:  # a pipe whose writer may still come
            time.sleep(0.01)
    raise BadInput(name, "file", None, f"at most {most} bytes")


def write_whole(texts: Mapping[Path, str | bytes]) -> None:
    """Write files, text or bytes, that belong together; raises BadInput.

    All are complete before the first one takes its place; Ctrl-C waits for that.
    """
    streams = any(map(is_stream, texts))  # whose reader may let us wait for ever
    with nullcontext() if streams else Delay():
        _write_whole(texts)


def _write_whole(texts: Mapping[Path, str | bytes]) -> None:
    staged: dict[str, Path] = {}  # places by their temporaries: two names may be of one place
    path = Path()
    try:
        for path, text in texts.items():
            if is_stream(path):
                continue
            place = path.resolve()
            temporary = f"{place.parent}/.{place.name}.{secrets.token_hex(4)}"
            with open(temporary, "xb", opener=_with_mode_of(place)) as out:
                staged[temporary] = place
                out.write(_bytes(text))
                out.flush()
                os.fsync(out.fileno())
        for path, text in texts.items():
            if is_stream(path):
                _stream(path, text)
        for temporary, path in list(staged.items()):
            os.replace(temporary, path)
            del staged[temporary]
    except OSError as error:
        raise BadInput(str(path), "file", None, f"a place to write to ({error.strerror})") from None
    finally:
        for temporary in staged:
            Path(temporary).unlink(missing_ok=True)


def npz(arrays: Mapping[str, Any]) -> bytes:
    """The bytes of an NPZ file."""
    import numpy as np

    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def read_npz(file: Path | bytes, most: int = MOST_UNPACKED) -> dict[str, npt.NDArray[np.generic]]:
    """The arrays of an NPZ file, of ``most`` bytes at most; no pickles.

    Their sizes are compared with the file's before memory is taken for any.  Raises OSError where
    there is no file, and ValueError for whatever is none: bytes in a wrong place make the libraries
    below raise almost anything.
    """
    size = len(file) if isinstance(file, bytes) else file.stat().st_size
    try:
        with zipfile.ZipFile(io.BytesIO(file) if isinstance(file, bytes) else file) as packed:
            parts = packed.infolist()
            unpacked = sum(part.file_size for part in parts)
            if len(parts) > MOST_ARRAYS or len({part.filename for part in parts}) < len(parts):
                raise ValueError(f"{len(parts)} arrays, or two of one name")
            most = min(most, max(SMALL, RATIO * size))
            if unpacked > most:
                raise ValueError(f"{unpacked} bytes of arrays, more than {most}")
            members = {part.filename.removesuffix(".npy"): part for part in parts}
            texts = FEW_TEXTS + TEXTS * size
            return {name: _array(packed, part, texts) for name, part in members.items()}
    except OSError:
        raise
    except Exception as fault:
        raise ValueError(f"no complete NPZ file: {fault}") from None


def _array(packed: zipfile.ZipFile, part: zipfile.ZipInfo, texts: int) -> npt.NDArray[np.generic]:
    import numpy as np

    with packed.open(part) as file:
        dtype, count, begin = npy_header(file)
    if begin + count * dtype.itemsize != part.file_size:
        raise ValueError(f"{part.filename}: not as long as it says")
    if dtype.kind in "US" and count > texts:
        raise ValueError(f"{part.filename}: {count} texts")
    with packed.open(part) as file:
        array: npt.NDArray[np.generic] = np.lib.format.read_array(file, allow_pickle=False)
    return array


def npy_header(file: IO[bytes]) -> tuple[np.dtype[np.generic], int, int]:
    """Of an array in NumPy's format: the type, how many elements, and where they begin."""
    import numpy as np

    form = np.lib.format
    is_first = form.read_magic(file) == (1, 0)
    read = form.read_array_header_1_0 if is_first else form.read_array_header_2_0
    shape, _, dtype = read(file)
    return dtype, math.prod(shape), file.tell()


def check_writable(
    path: Path, suffixes: Sequence[str] = (), inputs: Iterable[Path | None] = ()
) -> None:
    """Refuse, before any work is done, a path that cannot or must not be written.

    ``suffixes``: what its name may end in, unless it is a stream.  ``inputs``: files that are read.
    """
    if is_stream(path):
        return
    try:
        place = path.resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise BadInput(str(path), "-o", None, f"a place to write to ({error})") from None
    if path.is_dir():
        raise BadInput(str(path), "file", None, "a file, not a folder")
    if suffixes and path.suffix.lower() not in suffixes:
        raise BadInput(str(path), "-o", None, f"a name that ends in {' or '.join(suffixes)}")
    if not place.parent.is_dir():
        link = f"{place.parent}, where this link leads"
        folder = link if path.is_symlink() else str(path.parent)
        raise BadInput(str(path), "file", None, f"an existing folder {folder}")
    if not os.access(place.parent, os.W_OK):
        raise BadInput(str(path), "file", None, "a folder that can be written to")
    for source in inputs:
        if source is not None and _same_file(place, source):
            raise BadInput(str(path), "-o", None, "another file than the one that is read")


def refuse_foreign(path: Path) -> None:
    """Raise BadInput where a report or an orbit's scene would replace a text that is none.

    An empty file is nothing.
    """
    beginning = _BEGINNINGS.get(path.suffix.lower())
    if beginning is None or not path.is_file():
        return
    try:
        with path.open("rb") as file:
            there = file.read(len(beginning))
    except OSError as fault:
        raise BadInput(str(path), "file", None, f"another name ({fault.strerror})") from None
    if there not in (b"", beginning):
        raise BadInput(str(path), "file", None, "another name: polhode did not write it")


def make_folder(folder: Path) -> None:
    """A folder to write to, made where it is not there; raises BadInput."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise BadInput(str(folder), "-o", None, f"a folder to write to ({reason})") from None


def called(path: Path) -> str:
    """What results call a file: its path as it was given, of an absolute one the name alone.

    Results are passed on, and whose folders they were made in is nobody's business.  A line of an
    error has the whole path: see :class:`FileName`.
    """
    return FileName(path.name, str(path)) if path.is_absolute() and path.name else str(path)


def is_stream(path: Path) -> bool:
    """Whether a path is written to as a stream: ``-`` for stdout, or what is no regular file."""
    if is_stdout(path) or os.path.abspath(path).startswith(_HANDLES):
        return True
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def is_stdout(path: Path) -> bool:
    """Whether a path means this process's standard output."""
    return path == STDOUT or os.path.abspath(path) in ("/dev/stdout", "/dev/fd/1")


def write_stdout(text: str | bytes) -> None:
    """Write to standard output; raises StdoutFault where it takes no more.

    A stream of text in its place, such as a StringIO, takes bytes that are text; others raise
    BadInput.
    """
    if isinstance(text, bytes) and not hasattr(sys.stdout, "buffer"):
        try:
            text = text.decode()
        except UnicodeDecodeError:
            expected = "a standard output that takes bytes (text alone can be written here)"
            raise BadInput(str(STDOUT), "-o", None, expected) from None
    try:
        if isinstance(text, str):
            sys.stdout.write(text)
        else:
            sys.stdout.flush()
            sys.stdout.buffer.write(text)
        sys.stdout.flush()
    except OSError as fault:
        raise StdoutFault(fault) from None


def _stream(path: Path, text: str | bytes) -> None:
    if is_stdout(path):
        write_stdout(text)
        return
    with open(path, "wb", buffering=0) as out:
        rest = memoryview(_bytes(text))
        while rest:
            rest = rest[out.write(rest) :]


def _same_file(place: Path, source: Path) -> bool:
    try:
        return place.exists() and os.path.samefile(place, source)
    except OSError as error:
        if error.errno == errno.ENOENT:
            return False
        return place == source.resolve()


def _bytes(text: str | bytes) -> bytes:
    return text.encode() if isinstance(text, str) else text


def _with_mode_of(place: Path) -> Callable[[str, int], int]:
    """Opens a new file with the permissions of the one that it is to replace.

    Where there is none the kernel takes the process's umask from what every new file has.  To ask
    for the umask would mean to change it, for all threads.
    """

    def opened(path: str, flags: int) -> int:
        try:
            mode = stat.S_IMODE(place.stat().st_mode)
        except OSError:
            return os.open(path, flags, 0o666)
        handle = os.open(path, flags, mode & 0o600)
        try:
            os.chmod(path, mode)
        except OSError:
            os.close(handle)
            os.unlink(path)
            raise
        return handle

    return opened
