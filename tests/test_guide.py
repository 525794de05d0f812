"""The guide: its commands and its Python are run, and print what stands there."""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
import subprocess
import sys
import warnings
from itertools import pairwise
from pathlib import Path

import pytest

import polhode
from polhode import cli
from polhode.closed_forms.families import FAMILIES
from polhode.output import guide
from polhode.scenes import keys
from polhode.scenes.shapes import SHAPES

TOPICS = ["index", *guide.topics()]


def blocks(topic: str) -> list[tuple[str, str, str]]:
    """Fenced blocks: language, text, and the paragraph before."""
    texts = re.split(r"^```(\w*)\n", guide.page(topic), flags=re.M)
    return [
        (texts[k], texts[k + 1], texts[k - 1].strip().rpartition("\n\n")[2])
        for k in range(1, len(texts), 4)
    ]


EXAMPLES = [
    (topic, kind, one[1], other[1])
    for topic in TOPICS
    for kind in ("text", "python")
    for one, other in pairwise([*blocks(topic), ("", "", "")])
    if one[0] == kind and (kind == "python" or one[1].startswith("$ "))
]


def long(text: str) -> bool:
    """Whether an example takes long, or prints the last digits of doubles."""
    return bool(re.match(r"\$ polhode (run|sweep|reference|section|map|check)", text))


def without_seconds(text: str) -> str:
    return re.sub(r"\b[\d.]+ m?s\b", "some s", text)


def commanded(command: str) -> str:
    """What a command prints on both streams, cut by ``| head -N``."""
    command, _, cut = command.partition(" | head -")
    program, *arguments = shlex.split(command)
    assert program == "polhode"
    both = io.StringIO()
    with contextlib.redirect_stdout(both), contextlib.redirect_stderr(both):
        assert cli.main(arguments) == 0, both.getvalue()
    lines = both.getvalue().splitlines(keepends=True)
    return "".join(lines[: int(cut)] if cut else lines)


def executed(text: str) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(compile(text, "guide", "exec"), {})
    return out.getvalue()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files that the pages show, under the names that they give them."""
    monkeypatch.chdir(tmp_path)
    for topic in TOPICS:
        for language, text, before in blocks(topic):
            if language == "toml":
                (name,) = re.findall(r"`([\w-]+\.toml)`", before)
                Path(name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.sample(16)
@pytest.mark.parametrize(
    ("topic", "kind", "text", "printed"),
    [
        pytest.param(*e, id=f"{e[0]}-{k}", marks=[pytest.mark.slow] * long(e[2]))
        for k, e in enumerate(EXAMPLES)
    ],
)
def test_every_example_prints_what_it_says(folder, topic, kind, text, printed):
    if "matplotlib" in text:
        pytest.importorskip("matplotlib").use("agg")
    if kind == "python":
        assert executed(text) == printed
        return
    for session in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, _, expected = session.partition("\n")
        assert without_seconds(commanded(command)) == without_seconds(expected), command


def test_every_page_has_an_example_and_every_file_is_a_scene(folder):
    assert {topic for topic, *_ in EXAMPLES} == set(TOPICS)
    for path in Path().glob("*.toml"):
        assert polhode.load(str(path)).times


def test_every_link_leads_to_a_page_and_a_heading():
    """Within the guide; a heading's anchor is its words in lower case, hyphens between."""
    heads = {
        topic: {
            re.sub(r"[^\w -]", "", head).lower().replace(" ", "-")
            for head in re.findall(r"^#+ (.*)$", guide.page(topic), re.M)
        }
        for topic in TOPICS
    }
    links = [
        (topic, *link)
        for topic in TOPICS
        for link in re.findall(r"\]\((?:(\w[\w-]*)\.md)?(?:#([\w-]+))?\)", guide.page(topic))
    ]
    assert len(links) > 40
    for topic, page, anchor in links:
        assert (page or topic) in heads, (topic, page)
        assert not anchor or anchor in heads[page or topic], (topic, page, anchor)


def test_the_glossary_is_in_alphabetical_order_and_each_entry_names_a_page():
    _, *parts = re.split(r"^## .*\n", guide.page("glossary"), flags=re.M)
    for part in parts:
        _, *entries = re.split(r"^### ", part, flags=re.M)
        names = [entry.partition("\n")[0] for entry in entries]
        assert names == sorted(names, key=str.lower)
        for entry in entries:
            assert set(re.findall(r"`polhode guide ([\w-]+)`", entry)) & {*TOPICS}, entry


def test_every_key_shape_family_and_name_is_told():
    scene, start = guide.page("scene"), guide.page("start")
    for section in keys.KEYS:
        for key in keys.KEYS[section]:
            assert re.search(rf"^\| `{key.name}` \| ", scene, re.M), key
    assert re.findall(r"^\| `(\w+)` \|", start, re.M) == list(SHAPES)
    rows = re.findall(r"^\| `([\w-]+)` \| .* \| `([\w/-]+)` \|", guide.page("closed-forms"), re.M)
    assert {family for family, _ in rows} == {family.name for family in FAMILIES}
    for family, case in rows:
        assert polhode.reference(case).kind == family
    told = guide.page("python")
    assert all(f"`polhode.{name}" in told for name in polhode.__all__ if name != "__version__")
    assert "<!--" not in scene + start + told


def test_the_seven_jobs_are_as_short_as_promised(folder):
    """Six lines for a convergence plot, eight of a scene, one command for a small page."""
    (scene,) = (text for language, text, _ in blocks("jobs") if language == "toml")
    assert len(scene.splitlines()) == 8
    (start,) = (x for x in blocks("start") if "cone.toml" in x[2])
    assert len(start[1].splitlines()) == 8
    (plot,) = (text for _, kind, text, _ in EXAMPLES if kind == "python" and "savefig" in text)
    own = plot.partition("\n\n\n")[2]
    assert len([x for x in own.splitlines() if x and not x.startswith("print")]) == 6
    commands = re.findall(r"^\$ (.*)$", guide.page("jobs"), re.M)
    (page,) = (command for command in commands if command.endswith("top.html"))
    commanded(page)
    assert 50_000 < Path("top.html").stat().st_size < 1_500_000


def test_the_verb_prints_pages_and_refuses_what_is_none(capsys):
    assert cli.main(["guide"]) == 0
    assert capsys.readouterr().out.startswith("# polhode's guide")
    assert cli.main(["guide", "scene", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["topics"] == guide.topics()
    for wrong in ("scen", "../cli", ""):
        assert cli.main(["guide", wrong]) == 2
        assert "expected jobs, commands, scene" in capsys.readouterr().err


def _options(verb):
    parser = cli._parser([verb])
    return next(a for a in parser._actions if a.dest == "verb").choices[verb]._option_string_actions


def test_the_options_that_the_guide_names_exist():
    texts = "\n".join(guide.page(topic) for topic in TOPICS)
    known = {option for verb in cli.VERBS for option in _options(verb)}
    assert set(re.findall(r"(?<![\w`-])--[a-z][a-z-]+", texts)) <= known | {
        "--help",
        "--print-completion",
        "--no-deps",  # of pip
    }


def test_the_table_of_the_page_on_ci_passes_all_its_gates(folder):
    """One table for `compare`, for the benchmark's checker, and for the job of a pipeline."""
    page = guide.page("ci")
    (made,) = re.findall(r"^\$ (polhode run .* -o mine.csv)$", page, re.M)
    commanded(made)
    (job,) = (text for language, text, _ in blocks("ci") if language == "yaml")
    (gate,) = re.findall(r"\.venv/bin/(polhode compare .*) > judged.txt$", job, re.M)
    assert "--at-least" in gate
    assert "worst" in commanded(gate)
    (checker,) = re.findall(r"^python (check.py .*)$", page, re.M)
    script, top, *rest = checker.split()
    top = Path(__file__).parents[1] / "reports/benchmark" / top
    command = [sys.executable, top.with_name(script), top, *rest]
    assert subprocess.run(command, capture_output=True).returncode == 0
    few = subprocess.run([*command[:-1], "40"], capture_output=True)
    assert few.returncode == 1


def test_the_table_of_verbs_is_the_programs(capsys):
    """Each verb once, and no option that the verb has not."""
    verbs = re.findall(r"^\| `polhode (\w+)([^`]*)` \|", guide.page("commands"), re.M)
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    told = capsys.readouterr().out
    assert [verb for verb, _ in verbs] == re.findall(r"^    (\w+)\b", told, re.M)
    for verb, usage in verbs:
        with pytest.raises(SystemExit):
            cli.main([verb, "--help"])
        told = capsys.readouterr().out
        for option in re.findall(r"(?<!\w)--?[a-z][a-z-]*", usage):
            assert re.search(rf"^  {option}\b", told, re.M), (verb, option)


@pytest.mark.slow
def test_the_notebook_runs_without_a_warning(tmp_path):
    """By nbclient, in a kernel of its own."""
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    found = nbformat.reads(guide.notebook(), as_version=4)
    nbformat.validate(found)
    found.cells.insert(
        0, nbformat.v4.new_code_cell("import warnings; warnings.simplefilter('error')")
    )
    nbclient.NotebookClient(
        found, timeout=100, resources={"metadata": {"path": tmp_path}}
    ).execute()
    outputs = [out for cell in found.cells if cell.cell_type == "code" for out in cell.outputs]
    assert not [out for out in outputs if out.get("name") == "stderr" and "arn" in out.text]
    shown = [out.data for out in outputs if "data" in out]
    assert sum("text/html" in data for data in shown) >= 4
    assert any("image/png" in data for data in shown)


def test_a_term_finds_its_entry_in_the_glossary_first():
    (page, heading, text), *rest = guide.search("precession")
    assert (page, heading) == ("glossary", "precession")
    assert text.startswith("The ")
    assert {"closed-forms", "start"} <= {page for page, *_ in rest}
    assert guide.search("chaos maps")[1][:2] == ("dynamics", "Chaos maps")
    for words in ("sleeping top", "Euler angles", "cusp", "middle axis"):
        assert guide.search(words)[0][0] == "glossary", words
    assert guide.search("no such words here") == []
