"""Many cases of each class, counted: ``python -m fuzz.campaign SECONDS [SEED]`` in tests/."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

import polhode
from fuzz import generate, promise

CLASSES = ("scene", "table", "command", "call")


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
    text_of, call = generate.call(random, scene)
    return text_of, *promise.of_call(call)


def main() -> None:
    """Run cases of all classes in turn for so many seconds; faults and counts on stdout."""
    seconds, first = float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    kinds = sys.argv[3].split(",") if len(sys.argv) > 3 else CLASSES
    began, counts, ends = time.monotonic(), Counter[str](), Counter[str]()
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
                for fault in faults:
                    print(f"== {kind} {seed}\n{text[:1500]}\n{fault[-1500:]}", flush=True)
            seed += 1
        os.chdir("/")
    print(f"seeds {first} to {seed}: {dict(counts)}\n{dict(sorted(ends.items()))}")


if __name__ == "__main__":
    main()
