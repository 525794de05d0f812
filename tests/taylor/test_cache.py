"""heyoka's cache of compiled code, read-only or absent, never stops a run; its threads."""

import json
import os
import re
import shutil
import subprocess
import sys
from threading import Barrier, Thread

import heyoka
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from polhode.taylor.heyoka import one_blas_thread, one_thread
from shared.motions import heavy_file

UNPRIVILEGED = ["setpriv", "--bounding-set", "-dac_override", "--inh-caps", "-dac_override"]


def polhode(arguments, cwd, cache, before=(), code=0, **environment):
    """What a verb says in a process of its own, with this cache directory: both its streams."""
    environment |= {"HEYOKA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    process = subprocess.run(
        [*before, sys.executable, "-m", "polhode", *arguments.split()],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
    )
    assert process.returncode == code, process.stderr
    return process.stdout, process.stderr


def about(cwd, cache, before=(), **environment):
    return json.loads(polhode("about --json", cwd, cache, before, **environment)[0])["cache"]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with a scene, a good cache, and what a run of the scene prints."""
    folder = tmp_path_factory.mktemp("cache")
    (folder / "scene.toml").write_text(heavy_file("5", samples=3))
    out, _ = polhode("run scene.toml --json", folder, folder / "good")
    assert (folder / "good" / "cache.db").stat().st_size > 10_000
    return folder, json.loads(out)["columns"]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["a file", "read-only"])
def test_a_bad_cache_changes_nothing(home, tmp_path, how):
    folder, states = home
    cache, before = tmp_path / "cache", ()
    if how == "a file":
        cache.write_text("x")
    else:
        cache.mkdir(mode=0o555)
        if os.geteuid() == 0:
            if shutil.which("setpriv") is None:
                pytest.skip("root writes everywhere, and setpriv is missing")
            before = UNPRIVILEGED
    out, err = polhode("run scene.toml --json", folder, cache, before)
    assert (json.loads(out)["columns"], err) == (states, "")  # nothing else on stdout
    facts = about(folder, cache, before)
    assert (facts["enabled"], facts["bytes"], "fault" in facts) == (True, None, True)


@pytest.mark.slow
def test_about_says_what_is_wrong_with_the_cache(home):
    folder, _ = home
    for cache, said in (
        (folder / "good", r"cache .* MB in "),
        ("/proc/polhode", r"cache        none, every run compiles again \("),
    ):
        assert re.search(f"^{said}", polhode("about", folder, cache)[0], re.MULTILINE)


@pytest.mark.slow
def test_the_cache_does_not_grow_once_it_holds_what_a_run_needs(home, tmp_path):
    """heyoka never finds its mp code again: each process would add some 0.8 MB."""
    folder, _ = home
    sizes = []
    for _ in range(3):
        polhode("run scene.toml --number mp --method taylor", folder, tmp_path)
        sizes.append((tmp_path / "cache.db").stat().st_size)
    assert 0 < sizes[1] == sizes[2]


@pytest.mark.slow
def test_the_environment_bounds_the_cache(home, tmp_path):
    folder, _ = home
    assert about(folder, tmp_path, POLHODE_CACHE_MB="7")["limit"] == 7_000_000
    none = tmp_path / "none"
    about(folder, none)  # which keeps what its own test compiles
    usual = about(folder, none)
    assert about(folder, none, POLHODE_CACHE_MB="0")["enabled"] is False
    polhode("run scene.toml", folder, none, POLHODE_CACHE_MB="0")
    assert about(folder, none) == usual  # nothing kept, and heyoka's file has no limit of 0
    assert usual["enabled"]
    assert usual["limit"] > 0
    _, err = polhode("about", folder, tmp_path, code=2, POLHODE_CACHE_MB="much")
    assert "POLHODE_CACHE_MB" in err
    assert err.count("\n") == 1


# -- Settings of the whole process are put back, whoever leaves last and however -------------------


def threads():
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


@pytest.fixture
def before():
    """Two BLAS threads, whatever the machine or the environment."""
    with threadpool_limits(2, user_api="blas"):
        yield threads()


def test_blas_has_one_thread_inside_and_those_of_before_outside(before):
    with one_blas_thread():
        assert set(threads()) == {1}
        with one_blas_thread():
            pass
        assert set(threads()) == {1}
    assert threads() == before != [1] * len(before)
    with pytest.raises(KeyError), one_blas_thread():
        raise KeyError
    assert threads() == before


def test_the_last_of_two_threads_puts_it_back(before):
    inside, values = Barrier(2, timeout=30), []

    def work():
        with one_blas_thread():
            inside.wait()
        values.append(threads())

    workers = [Thread(target=work) for _ in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert values[-1] == before == threads()


def test_heyoka_has_one_thread_inside_and_those_of_before_outside():
    before = heyoka.get_nthreads()
    heyoka.set_nthreads(3)
    try:
        with one_thread():
            assert heyoka.get_nthreads() == 1
        assert heyoka.get_nthreads() == 3
    finally:
        heyoka.set_nthreads(before)
