"""heyoka's cache of compiled code, read-only or absent, never stops a run; its threads."""

import json
import os
import shutil
import subprocess
import sys
from threading import Barrier, Thread

import pytest
from threadpoolctl import threadpool_info

from polhode.taylor.heyoka import one_blas_thread, one_thread
from shared.motions import heavy_file

UNPRIVILEGED = ["setpriv", "--bounding-set", "-dac_override", "--inh-caps", "-dac_override"]


def polhode(arguments, cwd, cache, before=(), **environment):
    """Run a verb in a process of its own, with this cache directory."""
    environment_left = {k: v for k, v in os.environ.items() if k != "HEYOKA_CACHE_DIR"}
    environment_left["PYTHONDONTWRITEBYTECODE"] = (
        "1"  # cut off at the limit, it would stay for all that follow
    )
    if cache is not None:
        environment["HEYOKA_CACHE_DIR"] = str(cache)
    return subprocess.run(
        [*before, sys.executable, "-m", "polhode", *arguments],
        cwd=cwd,
        env=environment_left | environment,
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with a scene, a good cache, and what a run of the scene prints."""
    folder = tmp_path_factory.mktemp("cache")
    (folder / "scene.toml").write_text(heavy_file("5", samples=3))
    process = polhode(["run", "scene.toml", "--json"], folder, folder / "good")
    assert process.returncode == 0, process.stderr
    assert (folder / "good" / "cache.db").stat().st_size > 10_000
    return folder, json.loads(process.stdout)["columns"]


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
    process = polhode(["run", "scene.toml", "--json"], folder, cache, before)
    assert process.returncode == 0, process.stderr
    assert (
        json.loads(process.stdout)["columns"] == states
    )  # nothing else on stdout, the same digits
    assert process.stderr == ""
    about = polhode(["about", "--json"], folder, cache, before)
    assert about.returncode == 0, about.stderr
    cache_facts = json.loads(about.stdout)["cache"]
    assert cache_facts["enabled"] is True
    assert cache_facts["bytes"] is None
    assert "fault" in cache_facts


@pytest.mark.slow
def test_about_says_what_is_wrong_with_the_cache(home):
    folder, _ = home

    def line(cache) -> str:
        lines = polhode(["about"], folder, cache).stdout.splitlines()
        (cache_line,) = (text for text in lines if text.startswith("cache "))
        return cache_line

    assert " MB in " in line(folder / "good")
    assert line("/proc/polhode").startswith("cache        none, every run compiles again (")


@pytest.mark.slow
def test_the_cache_does_not_grow_once_it_holds_what_a_run_needs(home, tmp_path):
    """heyoka never finds its mp code again: each process would add some 0.8 MB."""
    folder, _ = home
    arguments = ["run", "scene.toml", "--number", "mp", "--method", "taylor", "--json"]
    sizes = []
    for _ in range(3):
        assert polhode(arguments, folder, tmp_path).returncode == 0
        process = polhode(["about", "--json"], folder, tmp_path)
        sizes.append(json.loads(process.stdout)["cache"]["bytes"])
    assert 0 < sizes[1] == sizes[2]


@pytest.mark.slow
def test_the_environment_bounds_the_cache(home, tmp_path):
    folder, _ = home

    def about(cache, **environment):
        process = polhode(["about", "--json"], folder, cache, **environment)
        return json.loads(process.stdout)["cache"]

    assert about(tmp_path, POLHODE_CACHE_MB="7")["limit"] == 7_000_000
    about(tmp_path / "none")  # which keeps what its own test compiles
    usual = about(tmp_path / "none")
    assert about(tmp_path / "none", POLHODE_CACHE_MB="0")["enabled"] is False
    none = polhode(["run", "scene.toml"], folder, tmp_path / "none", POLHODE_CACHE_MB="0")
    assert none.returncode == 0
    assert about(tmp_path / "none") == usual  # nothing kept, and heyoka's file has no limit of 0
    assert usual["enabled"]
    assert usual["limit"] > 0


@pytest.mark.slow
def test_a_bound_that_is_none_is_refused(tmp_path):
    process = polhode(["about"], tmp_path, None, POLHODE_CACHE_MB="much")
    assert process.returncode == 2
    assert "POLHODE_CACHE_MB" in process.stderr
    assert process.stderr.count("\n") == 1


# -- Settings of the whole process are put back, whoever leaves last and however -------------------


def threads():
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


@pytest.fixture
def before():
    """Two BLAS threads, whatever the machine or the environment."""
    from threadpoolctl import threadpool_limits

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
    import heyoka

    before = heyoka.get_nthreads()
    heyoka.set_nthreads(3)
    try:
        with one_thread():
            assert heyoka.get_nthreads() == 1
        assert heyoka.get_nthreads() == 3
    finally:
        heyoka.set_nthreads(before)
