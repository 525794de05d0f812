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

import polhode
from shared.motions import heavy_file

UNPRIVILEGED = ["setpriv", "--bounding-set", "-dac_override", "--inh-caps", "-dac_override"]


#: Commands in one process, what is printed of each as JSON; of a refusal its line.
PROGRAM = """
import contextlib, io, json, sys
from polhode.cli import main
answers = []
for words in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = main(words.split())
    answers.append([code, out.getvalue()])
print(json.dumps(answers))
"""


def outputs_of(cache, *commands, cwd, before=(), **environment):
    """The exit code and the output of commands of one process with this cache; what it notes."""
    environment |= {"HEYOKA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    process = subprocess.run(
        [*before, sys.executable, "-c", PROGRAM, *commands],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout), process.stderr


RUN, ABOUT = "run scene.toml --json", "about --json"


def cache_of(answer):
    """What ``about`` says of the cache."""
    return json.loads(answer[1])["cache"]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with a scene, a good cache, and what a run of the scene prints."""
    folder = tmp_path_factory.mktemp("cache")
    (folder / "scene.toml").write_text(heavy_file("5", samples=3))
    (run, text), _ = outputs_of(folder / "good", RUN, "about", cwd=folder)
    assert (folder / "good" / "cache.db").stat().st_size > 10_000
    assert re.search(r"^cache .* MB in ", text[1], re.MULTILINE)
    return folder, json.loads(run[1])["columns"]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["a file", "read-only"])
def test_a_bad_cache_changes_nothing_and_about_says_what_is_wrong(home, tmp_path, how):
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
    (run, facts, text), err = outputs_of(cache, RUN, ABOUT, "about", cwd=folder, before=before)
    assert (json.loads(run[1])["columns"], err) == (states, "")  # nothing else on stdout
    facts = cache_of(facts)
    assert (facts["enabled"], facts["bytes"], "fault" in facts) == (True, None, True)
    assert re.search(r"^cache        none, every run compiles again \(", text[1], re.MULTILINE)


@pytest.mark.slow
def test_the_cache_does_not_grow_once_it_holds_what_a_run_needs(home, tmp_path):
    """heyoka never finds its mp code again: each process would add some 0.8 MB."""
    sizes = []
    for _ in range(3):
        outputs_of(tmp_path, "run scene.toml --number mp --method taylor", cwd=home[0])
        sizes.append((tmp_path / "cache.db").stat().st_size)
    assert 0 < sizes[1] == sizes[2]


@pytest.mark.slow
def test_the_environment_bounds_the_cache(home, tmp_path):
    folder, _ = home
    none = tmp_path / "none"
    (_, first), _ = outputs_of(none, ABOUT, ABOUT, cwd=folder, POLHODE_CACHE_MB="7")
    usual = cache_of(first)
    assert (usual["limit"], usual["enabled"]) == (7_000_000, True)
    (_, off), _ = outputs_of(none, RUN, ABOUT, cwd=folder, POLHODE_CACHE_MB="0")
    assert cache_of(off)["enabled"] is False
    # nothing kept, and heyoka's file has no limit of 0
    (again,), _ = outputs_of(none, ABOUT, cwd=folder, POLHODE_CACHE_MB="7")
    assert cache_of(again) == usual
    ((code, _),), err = outputs_of(tmp_path, "about", cwd=folder, POLHODE_CACHE_MB="much")
    assert code == 2
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


def refined(look):
    """A run by a refinement, which takes one thread; ``look`` at its progress."""
    how = {"at": [20], "method": "refined", "progress": lambda *_: look()}
    assert polhode.integrate("kovalevskaya/generic", "quad", **how).method == "refined"


def test_one_thread_inside_and_those_of_before_outside_whoever_leaves_last(before):
    inside, meeting, values = set(), Barrier(2, timeout=60), []

    def nested():
        inside.update([*threads(), heyoka.get_nthreads()])
        refined(lambda: inside.update(threads()))
        inside.update([*threads(), heyoka.get_nthreads()])
        raise KeyError

    def work():
        refined(lambda first=[0]: first and (first.pop(), meeting.wait()))
        values.append(threads())

    before_of_heyoka = heyoka.get_nthreads()
    heyoka.set_nthreads(3)
    try:
        with pytest.raises(KeyError):
            refined(nested)
        assert inside == {1}
        assert threads() == before != [1] * len(before)
        workers = [Thread(target=work) for _ in range(2)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        assert values[-1] == before == threads()
        assert heyoka.get_nthreads() == 3
    finally:
        heyoka.set_nthreads(before_of_heyoka)
