"""The house: the layer table, rooms, types, and what a verb may import."""

import ast
import inspect
import json
import os
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

import polhode
from campaigns import more_cases
from shared.tools import python

TOP = Path(__file__).parents[1]


def test_a_room_with_an_underscore_is_its_package_s_own():
    source = TOP / "src/polhode"
    for path in [source / "__init__.pyi", *source.rglob("*.py")]:
        packages = set(re.findall(r"polhode\.(\w+)\._\w+\.\w", path.read_text()))
        assert packages <= {path.relative_to(source).parts[0]}, path


#: Files in a folder, at most: where a room is fuller, it has rooms of its own.
#: In verbs a file a verb, and two that they share.
MOST_FILES = 16


def test_no_folder_is_crowded():
    source = TOP / "src/polhode"
    for folder in [source, *(f for f in source.rglob("*") if f.is_dir())]:
        files = [f for f in folder.glob("*.py") if f.name != "__init__.py"]
        assert len(files) <= MOST_FILES, folder


def test_the_table_of_rooms_is_that_of_the_folders():
    """It named a room that was gone, and files that were elsewhere."""
    source, text = TOP / "src/polhode", (TOP / "src/polhode/README.md").read_text()
    rooms = dict(re.findall(r"^\| `(\w+/\w+)/` \| (.*) \|$", text, re.M))
    families = {name.replace("-", "_") for name in polhode.cases().column("reference")}
    inner_rooms = {}
    for path in source.glob("*/*/__init__.py"):
        room, inner = path.parts[-3:-1]
        if room != "closed_forms" or inner not in families:
            docstring = ast.get_docstring(ast.parse(path.read_text())) or ""
            inner_rooms[f"{room}/{inner}"] = docstring.partition("\n")[0].rstrip(".")
    assert rooms == inner_rooms
    text += (TOP / "CONTRIBUTING.md").read_text()
    for name in re.findall(r"`([\w./]+/[\w./]*)`", text):
        assert any((top / name).exists() for top in (TOP, source)), name


def signatures() -> Iterator[tuple[str, object]]:
    """Every annotation of a public name: of functions, of classes' fields and methods."""
    for name in polhode.__all__:
        thing = getattr(polhode, name)
        if not inspect.isclass(thing):
            yield from ((name, kind) for kind in getattr(thing, "__annotations__", {}).values())
            continue
        for owner in thing.__mro__:
            if not owner.__module__.startswith("polhode"):
                continue
            for key, value in vars(owner).items():
                if key.startswith("_") and key not in ("__call__", "__getitem__", "__iter__"):
                    continue
                function = getattr(value, "fget", None) or getattr(value, "func", value)
                function = getattr(function, "__func__", function)
                if callable(function):
                    kinds = getattr(function, "__annotations__", {}).values()
                    yield from ((f"{name}.{key}", kind) for kind in kinds)
        fields = inspect.get_annotations(thing)
        yield from ((f"{name}.{key}", kind) for key, kind in fields.items() if key[0] != "_")


def test_a_room_s_docstring_names_what_is_there():
    """Some described other rooms: what had gone elsewhere, or what the room once was."""
    source = TOP / "src/polhode"
    for file in source.rglob("__init__.py"):
        docstring = ast.get_docstring(ast.parse(file.read_text())) or ""
        for role, name in re.findall(r":(mod|func|class):`~?([\w.]+)`", docstring):
            home, _, last = name.rpartition(".")
            assert hasattr(import_module(home), last) or import_module(name), (file, role)
        for name in re.findall(r"``([\w/]+\.(?:py|md))``", docstring):
            folders = (source, file.parent, *(f for f in file.parent.iterdir() if f.is_dir()))
            assert any((folder / name).is_file() for folder in folders), (file, name)


def test_the_front_door_is_typed():
    """No ``Any`` in what a user gives and gets."""
    annotations = list(signatures())
    assert len(annotations) > 400
    assert {name for name, kind in annotations if re.search(r"\bAny\b", str(kind))} == set()


USED = """\
from fractions import Fraction

import numpy as np
import polhode

top = polhode.top(moments=[1, 1, 0.5], centre=[0, 0, 1], weight=Fraction(2), angles=[0, "pi/6", 0],
                  rates=np.array([0.0, 0.0, 8.0]), end=2)
run = polhode.integrate(top, at=np.linspace(0, 2, 5), tol=1e-12)
digits: float = polhode.compare(run).worst
page: polhode.Page = run.view(end="3/2")
page.save("top.html")
labels: list[str] = [panel.get_ylabel() for panel in run.plot("angles")]
label: str = run.plot("omega").get_ylabel()
p: float = float(polhode.reference(top).at([1, "1/3"], 20)[0][0] - 1)
kinetic = sum(abs(x) for x in polhode.reference(top).at([1])[0][:3])
polhode.compare({"t": run.t, "p": np.asarray(run.states)[:, 0]}, top)
polhode.compare([[1.0] * 6], top, at=[1])
angle = run.angles_at(0.5)
many: polhode.Ensemble = polhode.integrate_many(top, {"start.rates[3]": "7:9:3"}, at=(0, 1))
fine: bool = bool(polhode.chaos_map(top, (3, 3), h=3, f="1/2").fli.max() > 0)
largest: float = float(run.states[:, 0].max() + run("1/3")[0] + run([0, 1])[:, 2].max())
extended = polhode.integrate("lagrange/nutation", "extended", at=[1])
rows = polhode.integrate("lagrange/nutation", "quad", at=[1])
worst: float = polhode.testing.assert_digits(run, top, at_least=9).worst
"""

ANY_STATES = "ndarray[float64] | ndarray[longdouble] | ndarray[object_]"

#: What the checker is asked to name, and the name: by the number type, where that is known.
REVEALED = {
    'polhode.integrate("lagrange/nutation").states': "ndarray[float64]",
    'polhode.integrate(top, "double", digits=9).states': "ndarray[float64]",
    "extended.states": "ndarray[longdouble]",
    "extended.attitude": "ndarray[longdouble] | None",
    "rows.states": "ndarray[object_]",
    'rows("1/2")': "ndarray[object_]",
    "rows([0, 1])": "ndarray[object_]",
    'run["p"]': "ndarray[float64]",
    'rows["p"]': "ndarray[object_]",
    'rows["t"]': "ndarray[float64]",
    "run.omega": "ndarray[float64]",
    "extended.gamma": "ndarray[longdouble]",
    'polhode.Part("cone", mass=0.05, radius="3 cm", height=1).units': "str",
    'run.events["high"].t': "ndarray[float64]",
    "polhode.integrate(top, digits=30).states": ANY_STATES,
    'polhode.load_run("run.npz").states': ANY_STATES,
    "polhode.testing.assert_digits(run, top, 9).times": "tuple[Fraction, ...]",
}

WRONG = {
    "run.view(end=[1])": "arg-type",
    "polhode.view(top).save(3)": "arg-type",
    "polhode.top(moments=5)": "arg-type",
    "run.states + 'x'": "operator",
    "run.states.nonsense": "attr-defined",
    "run.view().text + 1": "operator",
    "polhode.integrate(top, at=3)": "call-overload",
    "run[0]": "call-overload",
    'run.plot("omega")[0]': "index",
    "polhode.reference(top).at([1])[0][0].nonsense": "attr-defined",
}


def revealed(output: str) -> list[str]:
    """The types that the checker named, as short as they can be."""
    short = {
        r"tuple\[Any, \.\.\.\], ": "",
        r"\bdtype\[((?:[^][]|\[[^]]*\])*)\]": r"\1",
        r"(\w+\.)+": "",
        r"floating\[_64Bit \| [^]]*\]": "longdouble",
    }
    types = re.findall(r'note: Revealed type is "(.*)"', output)
    for long, text in short.items():
        types = [re.sub(long, text, x) for x in types]
    return types


@pytest.mark.slow
def test_types_tell_a_user_what_is_wrong(tmp_path):
    """mypy of a script, in which each fault has to be ignored by its name.

    As it looks at polhode itself, whose results it keeps and finds again.
    """
    script = tmp_path / "user.py"
    every = "".join(f"polhode.{name}\n" for name in polhode.__all__)
    types = "".join(f"reveal_type({text})\n" for text in REVEALED)
    wrong = "".join(f"{text}  # type: ignore[{code}]\n" for text, code in WRONG.items())
    script.write_text(USED + every + types + wrong)
    environment = {**os.environ, "MYPYPATH": "src"}
    said = python("-m", "mypy", "src/polhode", str(script), cwd=TOP, env=environment).stdout
    assert not re.search(r"user\.py:\d+: error:", said), said
    assert revealed(said) == [*REVEALED.values()]


def test_nobody_computes_at_a_precision_that_others_share():
    """Mpmath's context and flint's are imported where they are made private, and nowhere else."""
    private = {"numbers/mpmath_context.py", "numbers/flint_context.py"}
    private.add("certificates/verify.py")  # which is to run without polhode, and is held by it
    shared = re.compile(r"^ *(import mpmath|from mpmath import (?!libmp)|from flint.*\bctx)", re.M)
    for path in (TOP / "src/polhode").rglob("*.py"):
        name = path.relative_to(TOP / "src/polhode").as_posix()
        if name not in private:
            assert not shared.search(path.read_text()), name


def test_locks_stand_in_one_place_and_properties_hold_none():
    """Two locks that two threads take in different orders are a wait without end."""
    imports = r"^[ \w]*import .*\b({0})\b|\b(functools|threading|multiprocessing)\.({0})\b"
    banned = {
        "common/values.py": "cached_property",
        "common/interrupts.py": "R?Lock|Condition|Semaphore|BoundedSemaphore",
    }
    for place, words in banned.items():
        pattern = re.compile(imports.format(words), re.M)
        files = set()
        for path in (TOP / "src/polhode").rglob("*.py"):
            text = re.sub(
                r"^from polhode\.common\.\w+ import .*$", "", path.read_text(), flags=re.M
            )
            if pattern.search(text):
                files.add(path.relative_to(TOP / "src/polhode").as_posix())
        assert files == {place}


def test_tracked_text_names_no_machine():
    """No absolute path of a machine in the sources, cases, reports or documents."""
    pattern = re.compile(r"(?<![\w.])/(home|root|work|tmp|Users)/")
    for folder in ("src", "cases", "reports", "."):
        for path in (TOP / folder).glob("**/*" if folder != "." else "*"):
            if path.suffix in (".py", ".toml", ".md", ".json", ".cff"):
                assert not pattern.search(path.read_text()), path


def imported_by(*commands: list[str]) -> set[str]:
    code = (
        "import sys; from polhode.cli import main; "
        f"assert [main(one) for one in {commands!r}] == [0] * {len(commands)}; "
        "print(*sorted(sys.modules), file=sys.stderr)"
    )
    return set(python("-c", code, check=True).stderr.splitlines()[-1].split())


@pytest.mark.slow
def test_a_verb_imports_nothing_heavy_that_it_does_not_need():
    run = imported_by(["run", "euler/sphere", "--json"])
    assert "heyoka" in run
    assert not {"matplotlib", "scipy", "sympy"} & run
    light = ["list", "--json"], ["reference", "euler/sphere", "--json"]
    assert "heyoka" not in imported_by(*light)
    assert not {"numpy", "flint", "mpmath"} & imported_by(["list"])


@pytest.mark.slow
def test_a_run_imports_no_room_that_it_does_not_need():
    """A warm run is to cost little more than importing heyoka."""
    modules = imported_by(["run", "kovalevskaya/generic", "--at", "1"])
    own = {name.removeprefix("polhode.") for name in modules if name.startswith("polhode.")}
    needless = {"figures", "dynamics", "checks", "enclosures", "refined", "closed_forms"}
    assert not needless & {name.partition(".")[0] for name in own}
    verbs = {"catalogue", "deliver", "notes", "options", "scene_options", "terminal"}
    assert {name for name in own if name.startswith("verbs.")} == {f"verbs.{x}" for x in verbs}
    code = "import polhode, sys; polhode.integrate('euler/sphere'); print(*sys.modules)"
    modules = python("-c", code, check=True).stdout
    assert not re.findall(r"polhode\.(?:closed_forms|verbs|output)[.\w]*", modules)


def test_every_fault_made_by_hand_stands_once_in_its_file():
    """A list that the code has left behind tells nothing: nine rows of it once did not."""
    files = [TOP / "tests/measure" / name for name in ("mutants.json", "checker.json")]
    rows = [row for file in files for row in json.loads(file.read_text(encoding="utf-8"))]
    assert len(rows) > 200
    counts = {row["id"]: (TOP / row["file"]).read_text().count(row["old"]) for row in rows}
    assert {name for name, count in counts.items() if count != 1} == set()
    tests = {test.partition("::")[0] for row in rows for test in row["tests"]}
    assert {test for test in tests if not (TOP / test).exists()} == set()


@pytest.mark.parametrize("name", more_cases.CAMPAIGNS)
def test_a_campaign_calls_a_check_that_stands_in_its_file(name):
    path, call = more_cases.CAMPAIGNS[name]
    check = re.search(r"\b(?:test_)?(\w{20,})\(", call)[1]
    assert re.search(rf"^def (test_)?{check}\(", (TOP / f"tests/{path}.py").read_text(), re.M)


#: Rooms whose functions are asked with a scene and answer with a motion's numbers.
_DOORS = ("runs", "dynamics", "judging", "proofs", "equations", "enclosures", "figures", "output")


@pytest.mark.slow
def test_a_door_says_what_of_a_scene_it_takes():
    """So that what a body gets beyond today's is refused where it is not known, not ignored."""
    silent = []
    for room in _DOORS:
        for path in (TOP / "src/polhode" / room).rglob("*.py"):
            tree = ast.parse(path.read_text())
            named = {id(x.value) for x in ast.walk(tree) if isinstance(x, ast.Attribute)}
            for call in ast.walk(tree):
                if isinstance(call, ast.Call) and ast.unparse(call.func) == "library.load":
                    argument = ast.unparse(call.args[0])
                    takes = any(x.arg == "takes" for x in call.keywords)
                    if not takes and id(call) not in named and argument != "name":  # its name alone
                        silent.append(f"{path.name}: {ast.unparse(call)}")
    assert not silent


#: Participles and pronouns that name nothing by themselves.
_VAGUE = re.compile(
    "_*(found|told|asked|made|given|known|held|kept|seen|done|taken|begun|placed|turned|wanted"
    "|one|other|what|way|put)_*"
)
#: How often the package may bind one of them: as often as it does, in public keywords above all.
_MOST_VAGUE = 113


def _vague_bindings(tree: ast.AST) -> int:
    """How often a vague name is bound, but for ``other`` of Python's operators, its own word."""
    count = 0
    for node in ast.walk(tree):
        name = ""
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            name = node.name
            if isinstance(node, ast.FunctionDef) and name.startswith("__"):
                count -= [a.arg for a in node.args.args] == ["self", "other"]
        elif isinstance(node, ast.arg):
            name = node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            name = node.id
        count += bool(_VAGUE.fullmatch(name))
    return count


@pytest.mark.slow
def test_names_do_not_get_vaguer():
    """A local variable, too, is named by what it is: CONTRIBUTING has ten examples."""
    trees = [ast.parse(path.read_text()) for path in (TOP / "src/polhode").rglob("*.py")]
    assert sum(map(_vague_bindings, trees)) <= _MOST_VAGUE


def test_a_name_is_of_one_class():
    """But for the checker, which imports nothing, and the regimes of each family."""
    names = [
        node.name
        for file in (TOP / "src/polhode").rglob("*.py")
        if file.name != "verify.py"
        for node in ast.parse(file.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef)
    ]
    assert {name for name in names if names.count(name) > 1} == {"Regime"}
