"""The first minutes: a welcome, a version, which extra is missing, completion, how to cite."""

import json
import re
import shlex
import shutil
import sys
import tomllib
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest

import polhode
from polhode import cli
from polhode.cli import main
from polhode.scenes import library

TOP = Path(__file__).parents[2]


def said(capsys, *arguments, code=0):
    assert main([*arguments]) == code
    output = capsys.readouterr()
    return output.out if code == 0 else output.err


def test_alone_it_says_what_it_is_and_three_commands_that_exist(capsys):
    output = said(capsys)
    assert len(output.splitlines()) <= 10
    commands = re.findall(r"^  polhode (.*?)(?:  |$)", output, re.M)
    assert len(commands) == 3
    for command in commands:
        words = shlex.split(command)
        options, rest = cli._parser(words).parse_known_args(words)
        assert not rest
        if getattr(options, "scene", None):
            polhode.load(options.scene)


def test_its_version(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out.strip() == f"polhode {polhode.__version__}"


def test_every_extra_that_is_named_is_there_and_quoted():
    """An unquoted bracket is a pattern in zsh."""
    with (TOP / "pyproject.toml").open("rb") as file:
        extras = set(tomllib.load(file)["project"]["optional-dependencies"])
    named = set()
    for path in (TOP / "src").rglob("*.py"):
        for before, extra in re.findall(r"pip install (.?)polhode\[([\w-]+)\]", path.read_text()):
            assert before in "'\"", path
            named.add(extra)
    assert {"figures", "frames", "shell"} <= named <= extras


def test_axes_are_shown_as_rows_of_numbers(capsys):
    """They were Python's lists of texts."""
    output = said(capsys, "show", "lagrange/turned-axes")
    (line,) = (line for line in output.splitlines() if line.startswith("axes"))
    assert (line.count("["), line.count("'")) == (3, 0)


def test_the_citation_is_one_record(capsys):
    output = said(capsys, "about", "--cite")
    bibtex = json.loads(said(capsys, "about", "--cite", "--json"))["bibtex"]
    assert bibtex in output
    assert output.count("\n@") == 1
    author, title, version, date, doi = (
        re.search(rf" {key} *= {{+(.*?)}}+,?\n", bibtex)[1]
        for key in ("author", "title", "version", "date", "doi")
    )
    assert version == polhode.__version__
    record = (TOP / "CITATION.cff").read_text(encoding="utf-8")
    assert f'\ntitle: "{title}"\n' in record
    assert f'\nauthors:\n  - name: "{author}"\n' in record
    assert f"\nversion: {version}\ndate-released: {date}\n" in record
    assert f'doi: "{doi}"' in record
    assert f"\nVersion {version} ({date}) · " in (TOP / "README.md").read_text(encoding="utf-8")
    assert f"\n## {version} ({date})\n" in (TOP / "CHANGELOG.md").read_text(encoding="utf-8")


def test_a_shell_completes_verbs_and_options(capsys, monkeypatch):
    pytest.importorskip("shtab")
    for shell in ("bash", "zsh"):
        output = said(capsys, "--print-completion", shell)
        assert "--max-steps" in output
        assert "compare" in output
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert "pip install 'polhode[shell]'" in said(capsys, "--print-completion", "bash", code=2)


# -- ``polhode list`` shows of each case what its file says, though it reads few of them -----------


@pytest.mark.slow
def test_the_catalogue_is_of_the_files_as_they_are():
    again = {}
    for name in polhode.cases().column("scene"):
        scene, text = polhode.load(name), (TOP / f"cases/{name}.toml").read_bytes()
        reference, fingerprint = polhode.reference(scene), sha256(text).hexdigest()[:16]
        names = reference.regime, reference.kind
        again[name] = [fingerprint, scene.title, [*scene.tags], *names]
    maker = "python tests/measure/catalogue.py"
    assert json.loads((TOP / "cases/catalogue.json").read_text("utf-8")) == again, maker


@pytest.fixture
def cases(tmp_path, monkeypatch):
    """A small library of its own."""
    for name in ("euler/sphere", "lagrange/nutation"):
        (tmp_path / name).parent.mkdir()
        shutil.copy(library.folder() / f"{name}.toml", tmp_path / f"{name}.toml")
    shutil.copy(library.folder() / library.FILE, tmp_path / library.FILE)
    monkeypatch.setattr(library, "folder", lambda: tmp_path)
    return tmp_path


def listed(capsys):
    assert main(["list", "--json"]) == 0
    columns = json.loads(capsys.readouterr().out)["columns"]
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return {row["scene"]: row for row in rows}


def test_known_cases_are_listed_without_being_read(cases, capsys, monkeypatch):
    right = listed(capsys)
    assert right["lagrange/nutation"]["reference"] == "lagrange"
    monkeypatch.setattr(library, "load", lambda name: pytest.fail(name))
    assert listed(capsys) == right


@pytest.mark.parametrize("broken", ["gone", "{", "[]", '{"x": 1}'])
def test_a_changed_case_and_a_catalogue_that_is_none_are_seen(cases, capsys, broken):
    right = listed(capsys)
    path = cases / "euler/sphere.toml"
    path.write_text(path.read_text().replace("Sphere turning freely", "another"))
    changed = listed(capsys)
    assert changed["euler/sphere"] == right["euler/sphere"] | {"title": "another"}
    if broken == "gone":
        (cases / library.FILE).unlink()
    else:
        (cases / library.FILE).write_text(broken)
    assert listed(capsys) == changed


# -- ``polhode new``: a commented scene that reads back --------------------------------------------


COMMENTED = ["bobylev-steklov/asymptotic", "euler/named-times", "euler/turned-symmetric"]
COMMENTED += ["hard/dzhanibekov-1e-3", "hard/near-quasi-periodic", "kovalevskaya/delaunay"]
COMMENTED += ["lagrange/nutation", "lagrange/lower-pole", "pendulum/hanging"]


@pytest.mark.parametrize("case", COMMENTED)
def test_a_commented_case_is_the_case(case, tmp_path, capsys):
    path, scene = tmp_path / "mine.toml", polhode.load(case)
    assert said(capsys, "new", str(path), "--like", case, "--json")
    own = {"source": "", "name": "mine"}
    assert replace(polhode.load(path), **own) == replace(scene, **own)
    lines = [x for x in path.read_text().splitlines() if x not in scene.source.splitlines()]
    assert lines
    assert all(line.startswith("# ") for line in lines)
    if case == "lagrange/nutation":
        assert re.search(r"\n# omega: \w.*\nomega = \[0.16, 0.3, 4.1\]\n", path.read_text())


@pytest.mark.parametrize(
    ("options", "moment"),
    [
        ([], None),
        (["--cone", "3 cm,5 cm,50 g"], 3 * 0.05 * 0.03**2 / 10),
        (["--disc", "0.03,0.05,0.1"], 0.1 * 0.03**2 / 2),
        (["--sphere", "30 mm,5 cm,100 g", "--tilt", "pi/4", "--spin", "10 rev/s"], 3.6e-5),
    ],
)
def test_a_solid_is_a_scene_in_si(options, moment, tmp_path, capsys):
    path = tmp_path / "top.toml"
    assert main(["new", str(path), *options]) == 0
    assert f"polhode run {path}" in capsys.readouterr().out
    scene = polhode.load(path)
    assert scene.units == "SI"
    if moment is not None:
        assert float(scene.body.moments[2]) == pytest.approx(moment, rel=1e-14)
    text = path.read_text()
    for name in ("g", "shape", "mass", "angles", "rates", "end", "samples"):
        assert re.search(rf"\b{name} += ", text)
        assert f"# {name}: " in text
