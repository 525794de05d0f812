"""README and guide: their commands and their Python are run, and print what stands there."""

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
from typing import NamedTuple

import pytest

import polhode
from polhode import cli

TOP = Path(__file__).parents[1]
GUIDE = TOP / "src/polhode/guide"


def guide(*words: str) -> dict:
    """What the verb says of a topic, or of words to search for."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert cli.main(["guide", *words, "--json"]) == 0
    return json.loads(out.getvalue())


TOPICS = guide()["topics"]
PAGES = {topic: guide(topic)["text"] for topic in ("index", *TOPICS)}
DOCUMENTS = {"README": (TOP / "README.md").read_text(encoding="utf-8"), **PAGES}


class Block(NamedTuple):
    """A fenced block: its language, its text, and the paragraph before it."""

    language: str
    text: str
    before: str


def blocks(text: str) -> list[Block]:
    """The fenced blocks, in order."""
    parts = re.split(r"^```(\w*)\n", text, flags=re.M)
    return [
        Block(parts[k], parts[k + 1], parts[k - 1].strip().rpartition("\n\n")[2])
        for k in range(1, len(parts), 4)
    ]


BLOCKS = {name: blocks(text) for name, text in DOCUMENTS.items()}
#: A block of commands; or one of Python, and what it prints.
EXAMPLES = [
    (name, block, following.text)
    for name in DOCUMENTS
    for block, following in pairwise([*BLOCKS[name], Block("", "", "")])
    if block.language == "python" or block.text.startswith("$ ")
]


def slow(number: int) -> bool:
    """Whether an example is of the slow tier: README's are fast, and a page's first if quick."""
    name, block, _ = EXAMPLES[number]
    first = EXAMPLES[number - 1][0] != name
    quick = re.match(r"\$ polhode (list|show|guide|about|new|verify|frequencies)|[^$]", block.text)
    return name != "README" and (name == "theorems" or not (first and quick))


def without_seconds(text: str) -> str:
    """Times of computing are not the same twice."""
    return re.sub(r"\b[\d.]+ m?s\b", "some s", text)


def commanded(command: str) -> str:
    """What a command prints on both streams, cut by ``| head -N``; a file that printf writes."""
    if command.startswith("printf "):
        return subprocess.check_output(command, shell=True, text=True)
    command, _, cut = command.partition(" | head -")
    program, *arguments = shlex.split(command)
    assert Path(program).name == "polhode"
    both = io.StringIO()
    with contextlib.redirect_stdout(both), contextlib.redirect_stderr(both):
        assert cli.main(arguments) == 0, both.getvalue()
    lines = both.getvalue().splitlines(keepends=True)
    return "".join(lines[: int(cut)] if cut else lines)


def executed(text: str) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(compile(text, "example", "exec"), {})
    return out.getvalue()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files that the documents show, under the names that they give them."""
    monkeypatch.chdir(tmp_path)
    for block in (block for name in BLOCKS for block in BLOCKS[name]):
        if block.language == "toml":
            (name,) = re.findall(r"`([\w-]+\.toml)`", block.before)
            Path(name).write_text(block.text, encoding="utf-8")
    return tmp_path


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize(
    ("name", "block", "printed"),
    [
        pytest.param(*example, id=f"{example[0]}-{k}", marks=[pytest.mark.slow] * slow(k))
        for k, example in enumerate(EXAMPLES)
    ],
)
def test_every_example_prints_what_it_says(folder, name, block, printed):
    """Commands in their order, as the later ones judge what the first ones wrote."""
    if "matplotlib" in block.text:
        pytest.importorskip("matplotlib").use("agg")
    if block.language == "python":
        assert without_seconds(executed(block.text)) == without_seconds(printed)
        return
    for session in re.split(r"^\$ ", block.text, flags=re.M)[1:]:
        command, _, expected = session.partition("\n")
        assert without_seconds(commanded(command)) == without_seconds(expected), command


def test_every_page_has_an_example_and_every_file_is_a_scene(folder):
    assert {name for name, *_ in EXAMPLES} == {*DOCUMENTS}
    for path in Path().glob("*.toml"):
        assert polhode.load(str(path)).times


def test_the_first_command_runs_its_main_job(folder):
    """All of the one line but for the environment and pip, which the project's CI goes through."""
    lines = re.findall(r"^ +(python3 -m venv.*)", DOCUMENTS["README"], re.M)
    first, second = (line.split(" && ") for line in lines)
    assert [part.split()[0] for part in first[:2]] == ["python3", ".venv/bin/pip"]
    assert [part.split()[0] for part in second] == ["python3", ".venv/bin/pip", ".venv/bin/python"]
    for command in first[2:]:
        assert commanded(command)
    assert Path("brick.csv").exists()


# -- links, names and options ----------------------------------------------------------------------


def anchors(text: str) -> set[str]:
    """Of the headings: their words in lower case, hyphens between."""
    heads = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_link_leads_to_a_file_or_a_heading(name):
    text, folder = DOCUMENTS[name], TOP if name == "README" else GUIDE
    for link in re.findall(r"(?:\]\(|src=\")((?!http)[^)\"|]+)[)\"]", text):
        path, _, anchor = link.partition("#")
        assert not path or (folder / path).is_file(), link
        # a wheel has the package alone
        assert name == "README" or (folder / path).resolve().is_relative_to(TOP / "src/polhode")
        if anchor:
            there = (folder / path).read_text(encoding="utf-8") if path else text
            assert anchor in anchors(there), link


SCENE = polhode.load("euler/sphere").source
BODY = "[body]\n" + SCENE.partition("[body]\n")[2].partition("[start]")[0]


TABLES = "body", "start", "run", "expect"  # of the scene
MORE = "section", "reference", "[events]", "[published]"
VALUES = "schema", "title", "tags", "cite", "units"


def words_listed(call, *arguments, **more):
    """Those that a refusal says it expects one of."""
    with pytest.raises(polhode.BadInput) as fault:
        call(*arguments, **more)
    return re.sub(".*one of the (keys|names) ", "", fault.value.expected).split(", ")


def keys_listed(path, text):
    """Those that a scene file of this text may have in place of another, or names of a value."""
    path.write_text(text)
    return words_listed(polhode.load, path)


def test_every_key_shape_family_and_name_is_told(tmp_path):
    scene, start, path = PAGES["scene"], PAGES["start"], tmp_path / "x.toml"
    keys = keys_listed(path, f"zzz = 1\n{SCENE}")
    assert {*keys} == {*VALUES, *TABLES, *(table.strip("[]") for table in MORE)}
    keys += keys_listed(path, SCENE.replace(BODY, "[[body.parts]]\nzzz = 1\n"))
    for table in TABLES:
        keys += keys_listed(path, SCENE.replace(f"[{table}]", f"[{table}]\nzzz = 1"))
    for table in MORE:
        keys += keys_listed(path, f"{SCENE}\n[{table}]\nzzz = 1\n")
    for key in keys:
        assert re.search(rf"^\| `{key}` \| ", scene, re.M), key
    shapes = words_listed(polhode.Part, "zzz", mass=1)
    assert re.findall(r"^\| `(\w+)` \|", start, re.M) == shapes
    rows = re.findall(r"^\| `([\w-]+)` \| .* \| `([\w/-]+)` \|", PAGES["closed-forms"], re.M)
    families = {*keys_listed(path, f"{SCENE}\n[reference]\nkind = 'zzz'\n")}
    with_cases = {entry.reference for entry in polhode.cases().entries.values()} - {"certified"}
    assert {family for family, _ in rows} == with_cases
    assert with_cases <= families  # beside those that tests register
    for family, case in rows:
        assert polhode.reference(case).kind == family
    page = PAGES["python"]
    assert all(f"`polhode.{name}" in page for name in polhode.__all__ if name != "__version__")
    assert "<!--" not in scene + start + page


def test_names_of_python_and_options_exist(capsys):
    """And each verb stands once in the table of verbs, with no option that it has not."""
    for name in re.findall(r"`polhode((?:\.[a-z_]+)+)\(", DOCUMENTS["README"]):
        part = polhode
        for word in name[1:].split("."):
            part = getattr(part, word)
    # the last of pip, pytest and reports/make.py
    names = {"--help", "--print-completion", "--no-deps", "--polhode-report", "--only"}
    verbs = re.findall(r"^\| `polhode (prove \w+|\w+)([^`]*)` \|", PAGES["commands"], re.M)
    assert [verb for verb, _ in verbs] == [*dict.fromkeys(verb for verb, _ in verbs)]
    assert cli.main(["zzz"]) == 2
    names_of_verbs = capsys.readouterr().err.rstrip().partition(": expected ")[2].split(", ")
    assert {verb.split()[0] for verb, _ in verbs} == {*names_of_verbs}
    for verb, usage in verbs:
        with pytest.raises(SystemExit):
            cli.main([*verb.split(), "--help"])
        options = set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", capsys.readouterr().out))
        assert set(re.findall(r"(?<!\w)--?[a-z][a-z-]*", usage)) <= options, verb
        names |= options
    assert set(re.findall(r"(?<![\w`-])--[a-z][a-z-]+", "\n".join(PAGES.values()))) <= names


# -- what the guide's pages promise ----------------------------------------------------------------


def test_the_table_of_the_page_on_ci_passes_all_its_gates(folder):
    """One table for `compare`, for the benchmark's checker, and for the job of a pipeline."""
    page = PAGES["ci"]
    (maker,) = re.findall(r"^\$ (polhode run .* -o mine.csv)$", page, re.M)
    commanded(maker)
    (job,) = (block.text for block in BLOCKS["ci"] if block.language == "yaml")
    (gate,) = re.findall(r"\.venv/bin/(polhode compare .*) > judged.txt$", job, re.M)
    assert "--at-least" in gate
    assert "worst" in commanded(gate)
    (checker,) = re.findall(r"^python (check.py .*)$", page, re.M)
    script, top, *rest = checker.split()
    top = TOP / "reports/benchmark" / top
    command = [sys.executable, top.with_name(script), top, *rest]
    assert subprocess.run(command, capture_output=True).returncode == 0
    assert subprocess.run([*command[:-1], "40"], capture_output=True).returncode == 1


def test_the_verb_prints_pages(capsys):
    assert cli.main(["guide"]) == 0
    assert capsys.readouterr().out.startswith("# polhode's guide")


@pytest.mark.parametrize(
    ("words", "first"),
    [
        ("precession", "polhode guide glossary  (precession)"),
        ("regular precession", "polhode guide closed-forms"),
        ("chaos maps", "polhode guide dynamics  (Chaos maps)"),
        *((x, "polhode guide glossary") for x in ("sleeping top", "Euler angles", "middle axis")),
    ],
)
def test_a_term_finds_its_entry_in_the_glossary_first(words, first):
    places = guide(*words.split())["text"].split("\n")[::2]
    assert any(place.startswith(first) for place in places[:2])


@pytest.mark.slow
def test_the_notebook_runs_without_a_warning(tmp_path):
    """By nbclient, in a kernel of its own."""
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.reads(guide("notebook")["text"], as_version=4)
    nbformat.validate(notebook)
    first = nbformat.v4.new_code_cell("import warnings; warnings.simplefilter('error')")
    notebook.cells.insert(0, first)
    where = {"metadata": {"path": tmp_path}}
    nbclient.NotebookClient(notebook, timeout=100, resources=where).execute()
    outputs = [out for cell in notebook.cells if cell.cell_type == "code" for out in cell.outputs]
    assert not [out for out in outputs if out.get("name") == "stderr" and "arn" in out.text]
    shown = [out.data for out in outputs if "data" in out]
    assert sum("text/html" in data for data in shown) >= 4
    assert any("image/png" in data for data in shown)


def test_events_known_by_name_are_explained(tmp_path):
    *names, _ = keys_listed(tmp_path / "x.toml", f"{SCENE}\n[[events]]\nname = 'zzz'\n")
    assert {"nutation", "flip"} < {*names}
    for name in names:
        assert f"`{name}`" in PAGES["outputs"], name
        # of which there is no expression that is zero
        assert name == "flip" or f"`{name}`" in PAGES["sweeps"], name
