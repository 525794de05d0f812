"""The checker of certificates as a file of its own, where little is installed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import polhode

CHECKER = Path(polhode.__file__).parent / "certificates" / "verify.py"


def test_without_flint_it_says_so_and_proves_nothing(tmp_path):
    (tmp_path / "flint.py").write_text("raise ImportError\n")
    command = [sys.executable, str(CHECKER), "x.cert"]
    ran = subprocess.run(
        command, capture_output=True, text=True, env={"PYTHONPATH": str(tmp_path)}, cwd=tmp_path
    )
    assert ran.returncode == 2
    assert ran.stdout == ""
    assert ran.stderr == "python-flint is needed: pip install python-flint\n"


def test_with_flint_it_reads_the_file(tmp_path):
    (tmp_path / "x.cert").write_text("{}")
    command = [sys.executable, str(CHECKER), "x.cert"]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert ran.returncode == 2
    assert ran.stderr == "x.cert: no certificate: expected the format 'polhode certificate 1'\n"
