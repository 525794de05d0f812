"""Other programs as processes of their own: what is asked of them, and what came back."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def ask(
    module: str, job: Mapping[str, Any], limit: float, cache: Path
) -> tuple[list[dict[str, Any]], str]:
    """The answers of ``python -m module`` to a job, and what ended it early, if anything did."""
    command = [sys.executable, "-m", module]
    try:
        done = subprocess.run(
            command,
            input=json.dumps(job).encode(),
            capture_output=True,
            timeout=limit,
            env=environment(cache),
        )
    except subprocess.TimeoutExpired as late:
        return _lines(late.stdout or b""), f"stopped after {limit:g} s"
    if done.returncode == 0:
        return _lines(done.stdout), ""
    last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
    told = f": {last[0]}" if last else ""
    return _lines(done.stdout), f"process ended with {done.returncode}{told}"


def environment(cache: Path) -> dict[str, str]:
    """The environment of a process whose compiled code is kept below ``cache``."""
    return {
        **os.environ,
        "HEYOKA_CACHE_DIR": str(cache / "heyoka"),
        "NUMBA_CACHE_DIR": str(cache / "numba"),
        "JAX_COMPILATION_CACHE_DIR": str(cache / "jax"),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
        "JAX_PLATFORMS": "cpu",
    }


def _lines(output: bytes) -> list[dict[str, Any]]:
    """The whole lines of JSON in an output; what else a process printed is passed over."""
    found = []
    for line in output.decode(errors="replace").splitlines():
        try:
            answer = json.loads(line)
        except ValueError:
            continue
        if isinstance(answer, dict):
            found.append(answer)
    return found
