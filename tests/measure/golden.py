"""Is every digit what it was?  What polhode gives, written down exactly and compared.

    python tests/measure/golden.py make OUT.json [--part NAME ...] [--sample K] [--workers N]
    python tests/measure/golden.py diff A.json B.json

``make`` goes through the parts in golden_parts.py, each in a process of its own, N at a time (2),
and writes what polhode gives, bit by bit, or how it refuses.  ``--sample K`` takes one entry
in K of each part.  It is polhode as that Python imports it that is asked: to compare two states of
the code, run this same script by the Python of either, on one machine, for vector units and
mathematical functions differ between machines.  A make that was interrupted goes on where it was.

``diff`` lists the entries that differ, in which part and by how many units of the last place, and
ends with 1 if there are any, or if one file has an entry that the other has not.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from golden_record import differences

_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def make(target: Path, asked: Sequence[str], sample: int, workers: int) -> None:
    """Write the record of the parts asked for, of all if none is named."""
    from golden_parts import PARTS

    if unknown := [name for name in asked if name not in PARTS]:
        sys.exit(f"--part {unknown[0]}: expected one of {', '.join(PARTS)}")
    parts = [name for name in PARTS if not asked or name in asked]
    began = time.monotonic()
    folder = Path(f"{target}.parts")
    folder.mkdir(parents=True, exist_ok=True)
    _same_code(folder / "of", sample)
    running: list[subprocess.Popen[bytes]] = []

    def one(part: str) -> int:
        command = [sys.executable, __file__, "part", str(folder), part, str(sample)]
        process = subprocess.Popen(command, env={**os.environ, **_ONE_THREAD})
        running.append(process)
        return process.wait()

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with ThreadPoolExecutor(workers) as pool:
        try:
            codes = dict(zip(parts, pool.map(one, parts), strict=True))
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in running:
                process.terminate()
    if failed := [part for part, code in codes.items() if code]:
        sys.exit(f"not finished: {', '.join(failed)}")
    record = {part: dict(_lines(_file(folder, part))) for part in parts}
    whole = json.dumps(record, indent=0, sort_keys=True) + "\n"
    beside = Path(f"{target}.new")
    beside.write_text(whole, encoding="utf-8")
    beside.replace(target)
    shutil.rmtree(folder)
    count = sum(map(len, record.values()))
    print(f"{target}: {count} entries, {time.monotonic() - began:.0f} s", file=sys.stderr)


def make_part(folder: Path, part: str, sample: int) -> None:
    """Add to a part's file what it lacks, an entry a line."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupted run would be a record, too
    from golden_parts import PARTS, recorded

    file = _file(folder, part)
    known = dict(_lines(file))
    text = "".join(json.dumps(line) + "\n" for line in known.items())
    file.write_text(text, encoding="utf-8")  # without a last line that a kill cut short
    entries = sampled(list(PARTS[part]()), sample)
    shown = time.monotonic()
    with file.open("a", encoding="utf-8") as out:
        for k, (key, entry) in enumerate(entries, 1):
            if key not in known:
                out.write(json.dumps([key, recorded(entry)]) + "\n")
                out.flush()
            if time.monotonic() - shown > 10 or k == len(entries):
                shown = time.monotonic()
                spent = f"{time.process_time():.0f} s of processor"
                print(f"{part}: {k} of {len(entries)}, {spent}", file=sys.stderr, flush=True)


def sampled(entries: Sequence[tuple[str, Any]], every: int) -> list[tuple[str, Any]]:
    """One in so many, always the same, spread over all that the names combine."""
    by_name = sorted(entries, key=lambda pair: zlib.crc32(pair[0].encode()))
    chosen = {key for key, _ in by_name[::every]}
    return [pair for pair in entries if pair[0] in chosen]


def _file(folder: Path, part: str) -> Path:
    return folder / f"{part.replace(' ', '-')}.jsonl"


def _lines(file: Path) -> Iterator[tuple[str, Any]]:
    """The entries of a part's file; a last line that was cut short is none."""
    if file.exists():
        for line in file.read_text(encoding="utf-8").splitlines(keepends=True):
            if line.endswith("\n"):
                key, value = json.loads(line)
                yield key, value


def _same_code(file: Path, sample: int) -> None:
    """Refuse to go on with a record that other code began."""
    import polhode

    digest = hashlib.sha256(str(sample).encode())
    home = Path(polhode.__file__).parent
    for path in sorted([*home.rglob("*.py"), *Path(__file__).parent.glob("golden*.py")]):
        digest.update(path.read_bytes())
    if not file.exists():
        file.write_text(digest.hexdigest())
    elif file.read_text() != digest.hexdigest():
        sys.exit(f"{file.parent}: begun by other code or for another sample: remove it")


def diff(one: Path, two: Path) -> int:
    """Print what differs; 1 if anything does."""
    texts = [path.read_text(encoding="utf-8") for path in (one, two)]
    records = [json.loads(text) for text in texts]
    found = list(differences(*records))
    for difference in found:
        print(difference)
    entries = sum(map(len, records[0].values()))
    if not found and texts[0] == texts[1]:
        print(f"equal: {entries} entries in {len(records[0])} parts")
        return 0
    print(f"not equal: {len(found)} of {entries} entries")
    return 1


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="what", required=True)
    making = commands.add_parser("make")
    making.add_argument("target", type=Path)
    making.add_argument("--part", nargs="+", default=[])
    making.add_argument("--sample", type=int, default=1)
    making.add_argument("--workers", type=int, default=2)
    within = commands.add_parser("part")  # what make calls
    within.add_argument("folder", type=Path)
    within.add_argument("part")
    within.add_argument("sample", type=int)
    comparing = commands.add_parser("diff")
    comparing.add_argument("files", nargs=2, type=Path)
    asked = parser.parse_args(words)
    match asked.what:
        case "make":
            make(asked.target, asked.part, asked.sample, asked.workers)
        case "part":
            make_part(asked.folder, asked.part, asked.sample)
        case "diff":
            return diff(*asked.files)
    return 0


if __name__ == "__main__":
    sys.exit(main())
