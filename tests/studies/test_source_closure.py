"""What a study's key is made of: the files that its rows import, and no others."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from polhode.studies import report, source_closure
from polhode.studies.source_closure import BESIDE, DATA, INSTEAD, TOP, closure, imported, unread

EVERY = sorted(path.relative_to(TOP).with_suffix("").as_posix() for path in TOP.rglob("*.py"))


def of(study: str) -> set[str]:
    """The files that a study's rows import."""
    return {*closure([f"studies/{study.replace('-', '_')}/rows"])}


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the package, of which keys are made."""
    top = tmp_path / "polhode"
    shutil.copytree(TOP, top, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(source_closure, "TOP", top)
    imported.cache_clear()
    yield top
    imported.cache_clear()


def test_a_key_changes_with_what_the_rows_import_and_with_nothing_else(copy):
    studies = ("accuracy", "events")
    before = [report.key(name, False) for name in studies]
    for file, changed in {
        "studies/accuracy/printed.py": [True, False],
        "studies/accuracy/page.py": [False, False],
        "studies/report.py": [False, False],
        "checks/published_figures.py": [True, False],
        "scenes/scene_file.py": [True, True],
        "equations/forms/routhian.py": [True, True],  # imported by the word of a scene
        "closed_forms/euler/crossings.py": [True, True],  # imported inside functions
        "proofs/prove_orbit.py": [False, False],
        "figures/page/motion.js": [False, False],
        "verbs/run.py": [False, False],
        "guide/forms.md": [False, False],
    }.items():
        whole = (copy / file).read_text(encoding="utf-8")
        (copy / file).write_text(f"{whole}\n# changed\n", encoding="utf-8")
        today = [report.key(name, False) for name in studies]
        assert [one != two for one, two in zip(today, before, strict=True)] == changed, file
        (copy / file).write_text(whole, encoding="utf-8")
    assert [report.key(name, False) for name in studies] == before
    assert [report.key(name, True) for name in studies] != before


def test_what_is_imported_in_another_way_than_by_its_name_is_followed():
    assert {"__main__", "cli", "verbs/run", "figures/motion_page"} <= of("stability")  # a process
    assert {"studies/isolated_process", "peers/cyrk", "studies/speed/own"} <= of("speed")
    assert {"runs/reevaluate", "equations/columns/hodographs"} <= of("accuracy")
    assert TOP / "figures/page/motion.js" in {*source_closure.sources(["figures/motion_page"])}


def test_studies_rest_on_different_files():
    assert "proofs/prove_orbit" in of("proofs") - of("accuracy")
    assert "judging/score/score" in of("accuracy") - of("proofs")
    assert not [name for name in of("long-run") if name.startswith(("verbs/", "figures/"))]
    for study in report.STUDIES:
        assert not [name for name in of(study) if name.endswith("/page") or "/page/" in name], study


def test_imports_that_a_text_does_not_tell_are_declared():
    declared = {*INSTEAD, *BESIDE}
    assert {name for name in EVERY if unread(name)} <= declared
    assert {name for name in BESIDE if not unread(name)} == {"runs/trajectory"}
    assert declared <= {*EVERY}


def test_files_that_are_read_as_data_are_declared():
    """Whatever finds a file beside itself; cases, and the sources themselves, are in every key."""
    here = {name for name in EVERY if "__file__" in (TOP / f"{name}.py").read_text("utf-8")}
    assert here - {"scenes/library", "enclosures/statement", "studies/source_closure"} == {*DATA}
    for folder in DATA.values():
        assert (TOP / folder).is_dir(), folder


NOTE = """
import atexit, os, sys

@atexit.register
def write():
    names = [name for name in sys.modules if name.partition(".")[0] == "polhode"]
    with open(os.path.join({folder!r}, str(os.getpid())), "w") as file:
        file.write(" ".join(names))
"""
#: Studies that take a second or two in their quick form.
CHEAP = ()
#: And some that take tens of seconds; the others take up to two minutes.
DEAR = ("events",)


def _marks(name):
    return () if name in CHEAP else pytest.mark.slow if name in DEAR else pytest.mark.campaign


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=_marks(name)) for name in report.STUDIES],
)
def test_what_a_study_loads_is_in_its_closure(name, tmp_path):
    """Of the process that runs it, and of all that it starts."""
    notes = tmp_path / "notes"
    notes.mkdir()
    (tmp_path / "sitecustomize.py").write_text(NOTE.format(folder=str(notes)))
    rows = f"polhode.studies.{name.replace('-', '_')}.rows"
    options = ", without=('CyRK', 'numbalsoda', 'diffrax')" if name == "speed" else ""
    path = os.pathsep.join([str(tmp_path), str(TOP.parent), os.environ.get("PYTHONPATH", "")])
    subprocess.run(
        [sys.executable, "-c", f"import {rows} as study; study.rows(True, None{options})"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path},
        check=True,
    )
    loaded = {module for note in notes.iterdir() for module in note.read_text().split()}
    files = {
        name if (TOP / f"{name}.py").is_file() else f"{name}/__init__".removeprefix("./")
        for name in (module.partition(".")[2].replace(".", "/") or "." for module in loaded)
    }
    assert f"studies/{name.replace('-', '_')}/rows" in files
    assert files - of(name) == set()
