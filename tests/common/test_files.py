"""Whole files: what they may be read by, whatever other threads write meanwhile."""

import os
import stat
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import polhode

pytestmark = pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
RUN = polhode.integrate("euler/rest", at=[1])


@pytest.fixture
def umask(request):
    before = os.umask(request.param)
    yield request.param
    assert os.umask(before) == request.param


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("umask", [0o022, 0o077, 0], indirect=True)
@pytest.mark.parametrize("had", [None, 0o600, 0o640, 0o400, 0o751])
def test_a_new_file_has_the_kernel_s_permissions_and_an_old_one_keeps_its_own(tmp_path, had, umask):
    path = tmp_path / "file.json"
    if had is not None:
        polhode.integrate("euler/rest", at=[2]).save(path)
        path.chmod(had)
    RUN.save(path)
    assert mode(path) == (0o666 & ~umask if had is None else had)
    assert [*tmp_path.iterdir()] == [path]
    path.chmod(0o600)
    assert polhode.load_result(path) == RUN


@pytest.mark.parametrize("umask", [0o077], indirect=True)
def test_nobody_else_may_write_what_threads_write_at_once(tmp_path, umask):
    """The umask belongs to the process: other threads' files, of other programs' code too."""
    interval, end, others = sys.getswitchinterval(), threading.Event(), set()

    def another() -> None:
        k = 0
        while not end.is_set():
            os.close(os.open(tmp_path / f"other{k}", os.O_CREAT | os.O_WRONLY, 0o666))
            others.add(mode(tmp_path / f"other{k}"))
            (tmp_path / f"other{k}").unlink()
            k += 1

    beside = threading.Thread(target=another)
    sys.setswitchinterval(1e-6)
    beside.start()
    try:
        with ThreadPoolExecutor(8) as pool:
            paths = [tmp_path / f"file{k}.json" for k in range(200)]
            list(pool.map(RUN.save, paths))
    finally:
        end.set()
        beside.join()
        sys.setswitchinterval(interval)
    assert {mode(path) for path in paths} | others == {0o600}
