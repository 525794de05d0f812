"""Many cases of each class, counted: ``python -m fuzz.campaign SECONDS [SEED [CLASSES]]``.

The classes apart by commas; the counts are lines of JSON, the last one of all.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

import polhode
from fuzz import attacks, generate, promise

CLASSES = ("scene", "table", "command", "call", *attacks.MAKERS)


def case(kind: str, seed: int, scene: polhode.Scene) -> tuple[str, list[str], object]:
    """Case ``seed`` of a class, in the present folder: how to say it, its faults, how it ended."""
    random = Random(f"{kind} {seed}")
    if kind == "scene":
        Path("case.toml").write_bytes(text := generate.scene_file(random))
        return text.decode(errors="replace"), *promise.of_command(["show", "case.toml"])
    if kind == "table":
        Path("case.csv").write_bytes(text := generate.table_file(random))
        command = ["compare", "case.csv", "top.toml"]
        return text.decode(errors="replace"), *promise.of_command(command)
    if kind == "command":
        words = generate.command(random)
        told = promise.of_command(words)
        for made in Path().iterdir():
            if made.name != "folder":
                made.unlink()
        generate.prepared(Path())
        return repr(words), *told
    if kind in attacks.MAKERS:
        Path("folder/in").mkdir(exist_ok=True)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            said, work = attacks.MAKERS[kind](random, scene)
            told = promise.of_command(work) if isinstance(work, list) else promise.of_call(work)
        return said, *told
    text_of, call = generate.call(random, scene)
    return text_of, *promise.of_call(call)


def tell(first: int, seed: int, *counts: Counter[str]) -> None:
    """What was done so far, as one line of JSON: cases, ends and cases with faults by class."""
    names = ("cases", "ends", "faults")
    told = {"seeds": [first, seed]} | dict(zip(names, map(dict, counts), strict=True))
    print(json.dumps(told, sort_keys=True), flush=True)


def main() -> None:
    """Run cases of all classes in turn for so many seconds; faults and counts on stdout."""
    seconds, first = float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    kinds = sys.argv[3].split(",") if len(sys.argv) > 3 else CLASSES
    began, (counts, ends, faults_of) = (
        time.monotonic(),
        (Counter[str](), Counter[str](), Counter[str]()),
    )
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        generate.prepared(Path())
        scene = polhode.load("top.toml")
        seed = first
        while time.monotonic() - began < seconds:
            for kind in kinds:
                at = time.process_time()
                text, faults, end = case(kind, seed, scene)
                took = time.process_time() - at
                counts[kind] += 1
                ends[f"{kind} -> {end}"] += 1
                if took > 3:
                    print(f"-- {kind} {seed} took {took:.1f} s: {text[:300]!r}", flush=True)
                faults_of[kind] += bool(faults)
                for fault in faults:
                    print(f"== {kind} {seed}\n{text[:1500]}\n{fault[-1500:]}", flush=True)
            seed += 1
            if seed % 100 == 0:
                tell(first, seed, counts, ends, faults_of)
        os.chdir("/")
    tell(first, seed, counts, ends, faults_of)


if __name__ == "__main__":
    main()
