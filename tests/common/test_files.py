"""Whole files: what they may be read by, whatever other threads write meanwhile."""

from __future__ import annotations

import os
import stat
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from polhode.common.files import write_whole

pytestmark = pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")


@pytest.fixture
def umask(request):
    before = os.umask(request.param)
    yield request.param
    assert os.umask(before) == request.param


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o027, 0], indirect=True)
def test_a_new_file_has_the_permissions_that_the_kernel_gives(tmp_path, umask):
    path = tmp_path / "new.json"
    write_whole({path: "{}"})
    with (tmp_path / "plain").open("w"):
        pass
    assert mode(path) == mode(tmp_path / "plain") == 0o666 & ~umask


@pytest.mark.parametrize("umask", [0o077], indirect=True)
@pytest.mark.parametrize("had", [0o600, 0o640, 0o666, 0o400, 0o751])
def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path, had, umask):
    path = tmp_path / "old.json"
    path.write_text("old")
    path.chmod(had)
    write_whole({path: "new"})
    assert (mode(path), [x.name for x in tmp_path.iterdir()]) == (had, ["old.json"])
    path.chmod(0o600)
    assert path.read_text() == "new"


@pytest.mark.parametrize("umask", [0o077], indirect=True)
def test_nobody_else_may_write_what_threads_write_at_once(tmp_path, umask):
    """The umask belongs to the process: other threads' files, of other programs' code too."""
    interval, done, others = sys.getswitchinterval(), threading.Event(), set()

    def another() -> None:
        k = 0
        while not done.is_set():
            os.close(os.open(tmp_path / f"other{k}", os.O_CREAT | os.O_WRONLY, 0o666))
            others.add(mode(tmp_path / f"other{k}"))
            (tmp_path / f"other{k}").unlink()
            k += 1

    beside = threading.Thread(target=another)
    sys.setswitchinterval(1e-6)
    beside.start()
    try:
        with ThreadPoolExecutor(8) as pool:
            paths = [tmp_path / f"file{k}" for k in range(200)]
            list(pool.map(lambda path: write_whole({path: "x"}), paths))
    finally:
        done.set()
        beside.join()
        sys.setswitchinterval(interval)
    assert {mode(path) for path in paths} | others == {0o600}


def test_the_umask_is_never_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "umask", None)
    write_whole({tmp_path / "a": "x", tmp_path / "b": b"y"})
    write_whole({tmp_path / "a": "z"})
    assert (tmp_path / "a").read_text() == "z"
