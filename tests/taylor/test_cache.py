"""heyoka's cache of compiled code, read-only, full, damaged or absent, never stops a run."""

from __future__ import annotations

import json
import os
import random
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from shared.motions import heavy_file

UNPRIVILEGED = ["setpriv", "--bounding-set", "-dac_override", "--inh-caps", "-dac_override"]


def polhode(arguments, cwd, cache, before=(), limit=None, **environment):
    """Run a verb in a process of its own, with this cache directory."""

    def small_files() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

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
        preexec_fn=small_files,
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


def fill(path: Path, good: Path, how: str) -> None:
    """Make a cache directory that is bad in some way."""
    if how == "a file":
        path.write_text("x")
        return
    path.mkdir()
    database = path / "cache.db"
    shutil.copy(good / "cache.db", database)
    data = database.read_bytes()
    if how == "garbage":
        database.write_bytes(random.Random(1).randbytes(100_000))
    elif how == "truncated":
        database.write_bytes(data[:5000])
    elif how == "flipped":
        database.write_bytes(data[:9000] + bytes(255 - x for x in data[9000:]))
    elif how == "empty":
        database.write_bytes(b"")
    elif how == "a folder":
        database.unlink()
        database.mkdir()
    elif how in ("read-only", "read-only, empty"):
        if how != "read-only":
            database.unlink()
        path.chmod(0o555)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["a file", "read-only, empty"])
def test_a_bad_cache_changes_nothing(home, tmp_path, how):
    folder, states = home
    cache: Path | None = tmp_path / "cache"
    more = {}
    if how == "full":
        more["limit"] = 20_480
    elif how == "nowhere":
        cache = Path("/proc/polhode/cache")
    elif how == "no home":
        cache, more = None, {"HOME": "", "XDG_CACHE_HOME": ""}
    else:
        fill(cache, folder / "good", how)
    if how.startswith("read-only") and os.geteuid() == 0:
        if shutil.which("setpriv") is None:
            pytest.skip("root writes everywhere, and setpriv is missing")
        more["before"] = UNPRIVILEGED
    process = polhode(["run", "scene.toml", "--json"], folder, cache, **more)
    assert process.returncode == 0, process.stderr
    assert (
        json.loads(process.stdout)["columns"] == states
    )  # nothing else on stdout, the same digits
    assert process.stderr == ""
    about = polhode(["about", "--json"], folder, cache, **more)
    assert about.returncode == 0, about.stderr
    cache_facts = json.loads(about.stdout)["cache"]
    assert cache_facts["enabled"] is True
    assert (cache_facts["bytes"] is None) == ("fault" in cache_facts)
    assert ("fault" in cache_facts) == (how != "empty")


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
        sizes.append(exit_code(tmp_path, folder))
    assert 0 < sizes[1] == sizes[2]


def exit_code(cache, folder) -> int:
    """The cache's size in bytes, by `polhode about`."""
    return json.loads(polhode(["about", "--json"], folder, cache).stdout)["cache"]["bytes"]


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
@pytest.mark.parametrize("wrong", ["much"])
def test_a_bound_that_is_none_is_refused(tmp_path, wrong):
    process = polhode(["about"], tmp_path, None, POLHODE_CACHE_MB=wrong)
    assert process.returncode == 2
    assert "POLHODE_CACHE_MB" in process.stderr
    assert process.stderr.count("\n") == 1
