"""Verbs × bad input: exit code 2, one line that says what was expected, and nothing is written."""

import shlex
from pathlib import Path

import pytest

import polhode
from polhode import cli
from shared.motions import free_file, heavy_file
from shared.results import EXAMPLES

VERBS = {name.partition(" ")[0] for name in EXAMPLES}
CASE = "lagrange/nutation"
GENERAL = "general/asymmetric-regular"
PROVE = "prove orbit grioli/precession"
TOP = free_file("at = [0, 1]")
EVENT = '\n[[events]]\nname = "{}"\nzero = "{}"\n'
ANGLES = "--what angles -o x.svg"
VARY = "--vary body.weight=1"
HUGE = heavy_file(samples=3).replace("weight = 1", "weight = 1e305")
OUT_OF_REACH = "body, start = 5e+304: expected rates, moments, their inverses and the weight up to"
TABLE = "this is a table, as for polhode compare FILE SCENE"
OTHER_FILE = "another file than the one that is read"

#: What the folder holds.
FILES = {
    "top.toml": TOP,
    "scene.json": TOP,
    "scene.csv.json": TOP,
    "heavy.toml": heavy_file(samples=3),
    "free.toml": TOP.replace("gamma", "#gamma"),
    "level.toml": free_file("at = [0, -1, 0]"),
    "future.toml": "schema = 3",
    "event.toml": TOP + EVENT.format("a\\nb", "p"),
    "many.toml": TOP + "".join(EVENT.format(f"e{k}", f"gamma3 - {k}/1000") for k in range(101)),
    "huge.toml": HUGE,
    "impossible.toml": heavy_file().replace("[2, 3, 4]", "[1, 1, 3]"),
    "slanted.toml": heavy_file().replace('["2/7", "3/7", "6/7"]', "[1, 0, 1]"),
    "near-one.toml": heavy_file().replace("[2, 3, 4]", '[1, "1 + 1e-320", 0.5]'),
    "mine.toml": polhode.load(CASE).source,
    "table.csv": "t,p\n0,0.3\n",
    "orbit.json": '{\n "format": "polhode result 2"\n}',
    "table.npz": "t,p\n0,1\n",
    "angles.csv": "t,psi\n0,1\n",
    "mine.md": "# Mine\n",
}
LINKS = {
    "link.csv": "top.toml",
    "link.svg": "table.csv",
    "x.csv": "nowhere/y.csv",
    "same.npz": "y.npz",
}

#: Commands, and a part of what is said of them.  {folder}: where they run.
REFUSED = {
    # -- verbs, options and names that are none, or of another program
    "rum": "did you mean 'run'?",
    f"rnu {CASE}": "report, guide, about (did you mean 'run'?)",
    f"integrate {CASE}": "VERB = integrate: expected run SCENE",
    "validate table.csv": "expected compare FILE SCENE",
    "help run": "expected polhode --help, or polhode VERB --help",
    "version": "expected polhode --version",
    "run": "SCENE",
    f"run {CASE} --frob": "--frob",
    f"run {CASE} and more": "expected nothing more",
    f"run {CASE} 'a\nb'": "a b",
    f"run {CASE} --digts 3": "did you mean '--digits'?",
    f"run {CASE} --output x.csv": "option = --output: expected -o, as it is called here",
    f"run {CASE} --rtol 1e-9": "option = --rtol: expected --tol, as it",
    f"run {CASE} --dt 0.1": "option = --dt: expected --every, as it",
    f"run {CASE} --n-jobs 2": "option = --n-jobs: expected --help, --number",  # it has no workers
    f"sweep {CASE} --n-jobs 2 {VARY}": "expected --workers, as it",
    "-- run top.toml": "polhode: command line: argument = --: expected it after the verb and its o",
    "run -- --digits 20 top.toml": "argument = --: expected it after the verb and its options",
    "run top.toml -- --digits 20": "argument = --: expected it after the verb and its options",
    "--print-completion fish!": "expected bash, zsh",
    "about x": "argument = x: expected nothing more",
    # -- limits of bodies, types, tolerances, digits and closed forms
    "run impossible.toml": "principal moments of which none exceeds the sum of the others",
    "run slanted.toml": "start.gamma = [1, 0, 1]: expected length exactly 1",
    "run near-one.toml": "number = double: expected a type of wider range",
    "run euler/sphere --tol 1e-17": "expected between eps = 2**-52 and 0.1",
    "run euler/sphere --digits 5000": "expected a whole number, 1 to 4000",
    "reference euler/largest-axis --at 1e101": "expected at most 10**100 radians turned",
    f"reference {GENERAL}": "expected a scene with a closed form, or polhode.certify",
    # -- scenes
    "run euler/separatrx": "did you mean 'euler/separatrix'",
    "show looping": "did you mean 'lagrange/looping'?",
    "run nutation.toml": "(did you mean 'lagrange/nutation'?)",
    "run mine": "did you mean the file mine.toml?",
    "run nosuch.toml": "a path",
    "run 'x\0y'": "a path",
    "run .": "directory",
    "show table.csv": TABLE,
    "run table.npz": TABLE,
    "show orbit.json": "a scene file (TOML): this is JSON: a result, as for polhode plot FILE",
    "run event.toml": "events[1].name = a b: expected text of one line that can be printed",
    "run many.toml": "events = 101 events: expected at most 100\n",
    "check nosuch": "a path",
    "show /dev/zero": "at most 100000 bytes",
    "list --tag kovalevski": "did you mean 'kovalevskaya'?",
    "list --tag nope": "one of the tags angles, ",
    # -- numbers and words
    f"run {CASE} --number duoble": "did you mean 'double'",
    f"run {CASE} --number": "expected",
    f"run {CASE} --digits 0": "digits = 0",
    f"run {CASE} --digits 1.5": "--digits = 1.5: expected a whole number\n",
    f"run {CASE} --digits many": "--digits = many: expected a whole number\n",
    f"run {CASE} --digits {'9' * 20}": f"--digits = {'9' * 20}: expected a whole number of at most",
    f"run {CASE} --digits {'1' * 17}": f"digits = {'1' * 17}: expected a whole number, 1 to 4000",
    f"run {CASE} --digits 30 --number double": "quad",
    f"run {CASE} --tol 1e-30": "tol = 1e-30: expected between eps",
    f"run {CASE} --tol soon": "tol = soon",
    f"run {CASE} --max-steps 0": "--max-steps = 0: expected 1 or more\n",
    f"run {CASE} --max-steps many": "whole number",
    f"run {CASE} --form principle": "did you mean 'principal'",
    f"run {CASE} --outputs angels": "did you mean 'angles'",
    f"plot {CASE} --what angels -o x.svg": "did you mean 'angles'?",
    f"check {CASE} --number flaot": "number = flaot",
    "check --propose": "--propose: expected SCENEs to propose bands for",
    f"prove orbitz {CASE}": "WHAT = orbitz: expected orbit, orbits, stability, chaos (did you",
    "prove": "WHAT",
    f"reference {CASE} --digits 0": "digits = 0",
    f"reference {GENERAL} --at 1": "closed form",
    f"section {GENERAL} --by '' --grid 2x2": "by = : expected momentum, height",
    f"certify {CASE} --at 1 --digits 400": "digits = 400: expected a whole",
    f"certify {GENERAL} --at 1 --events": "events in the scene",
    f"certify {GENERAL} --at 1 --max-seconds 0": "max_seconds = 0.0: expected a number above 0",
    f"certify {GENERAL} --at 1 --max-seconds soon": "--max-seconds = soon: expected a number\n",
    f"reference {CASE} --at 1 -o exact.toml": "expected a name that ends in .csv",
    f"run {CASE} --prove": "prove = True: expected digits given",
    f"run {CASE} --project 3 --no-project": "--no-project: not allowed with argument --project",
    f"orbits {GENERAL} --digits 20": "--digits = 20: expected it with --pick K, of one orbit\n",
    f"orbits {GENERAL} --grid 4x4 --crossings 1 --pick 9": "pick = 9: expected a number to 1:",
    f"orbits {GENERAL} -o x.toml": "x.toml",
    f"orbits {GENERAL} --grid 4": "--grid = 4: expected NxM, such as 9x8\n",
    f"orbits {GENERAL} --crossings 0": "--crossings = 0: expected 1 or more\n",
    f"family {GENERAL} --by h": "--to",
    f"family {GENERAL} --by g --to 1": "by = g: expected h, f",
    "order table.csv top.toml": "polhode order: FILE: expected two files or more",
    "section top.toml --grid 0x3": "--grid = 0x3: expected NxM, such as 9x8\n",
    f"{PROVE} --digits 201": "digits",
    f"{PROVE} --orbit nowhere.toml": "nowhere.toml",
    f"{PROVE} --period -1": "period",
    f"{PROVE} --period 1e400": "period",
    f"{PROVE} --h x": "h",
    f"{PROVE} --tries 3": "--tries",
    # -- reports
    "report": "expected scenes, and files of them",
    "report table.csv -o x.html": "polhode: table.csv: scene: expected a scene before it",
    "report nowhere.toml -o x.html": "nowhere.toml: SCENE",
    "report top.toml -o x.txt": "x.txt: -o: expected a name that ends in .html or .md or .csv",
    "report top.toml -o top.toml": "top.toml",
    "report top.toml top.toml -o x.html": "each scene once",
    "report top.toml broken.csv -o x.html": "broken.csv: file",
    "report top.toml --end 0 -o x.md": "--end = 0: expected a time other than 0",
    "report top.toml --number doubel -o x.md": "expected double, extended, quad, mp",
    "report top.toml -o x.html -o y/x.md": "y",
    "report top.toml --digits 0 -o x.md": "digits = 0: expected",
    "report top.toml --number double --digits 40 -o x.md": "digits = 40",
    "report top.toml table.csv=2h -o x.md": "table.csv=2h: SCENE",
    "report top.toml table.csv=1.2.3s -o x.md": "table.csv=1.2.3s: SCENE",
    "report top.toml table.csv= -o x.md": "table.csv=: SCENE",
    "report top.toml table.csv=0ms -o x.md": "table.csv: cost = 0 ms: expected a time above 0",
    "report top.toml table.csv=1e400s -o x.md": "cost = 1e400 s: expected a time above 0",
    "report top.toml table.csv=h=0 -o x.md": "table.csv: h = 0: expected the step of its method, a",
    "report top.toml table.csv=1s,h=x -o x.md": "h = x: expected the step of its method (unknown",
    "guide xyzzy": "expected",
    "guide ../cli": "expected jobs, start, scene",
    f"guide {'1' * 5000}": "polhode: guide",
    "compare table.csv top.toml --digits 30": "digits",
    "compare table.csv other.csv": "a table is judged by a motion",
    "compare table.csv": "the following arguments are required: SCENE",
    # -- times
    f"run {CASE} --at": "expected",
    f"run {CASE} --at ''": "--at",
    f"run {CASE} --at 1,,2": "--at",
    f"run {CASE} --at 1,soon": "--at = soon",
    f"run {CASE} --at 2,1": "run.at[2] = 1",
    f"run {CASE} --at -1,1": "one sign",
    f"run {CASE} --at 1,1.00000000000000000001": "differ when rounded to double",
    f"run {CASE} --at 1e400": "wider range",
    f"run {CASE} --at 0:1": "--at = 0:1: expected FROM:TO:N with N from 1",
    f"run {CASE} --at 0:1:0": "expected FROM:TO:N with N from 1",
    f"run {CASE} --at 0:1:99999999": "FROM:TO:N with N from 1 to 10000000",
    f"run {CASE} --at 0:x:3": "unknown name 'x'",
    f"run {CASE} --at 1,2 --end 5": "--end = 5: expected no value together with --at",
    f"run {CASE} --at 1,2 --every 5": "--every = 5: expected no value together with --at",
    f"run {CASE} --end 0": "--end = 0: expected a time other than 0",
    f"run {CASE} --end soon": "--end = soon: expected a time (",
    f"run {CASE} --end 1e400": "number = double: expected",
    f"run {CASE} --samples 1": "--samples = 1: expected a whole number from 2 to 1000000",
    f"run {CASE} --samples 1000001": "a whole number from 2 to 1000000",
    f"run {CASE} --every 0": "--every = 0: expected a time above 0",
    f"run {CASE} --every -1": "expected a time above 0; --end says the direction",
    f"run {CASE} --every 41": "expected a time that makes two to 1000000 times until t = 40",
    f"run {CASE} --every 1e-5": "that makes two to 1000000 times",
    f"run {CASE} --every 1 --samples 3": "--samples: not allowed with argument --every",
    f"view {CASE} --end -1,2 -o x.html": "end",
    f"orbit {GENERAL} --h 1e400": f"polhode: {GENERAL}",
    f"prove orbit {GENERAL} --h 1e400": f"polhode: {GENERAL}",
    f"frequencies {GENERAL} --end 1e308": f"polhode: {GENERAL}",
    # -- members of a sweep, numbers kept of them
    "sweep heavy.toml --vary body.weight=1:2:0": "body.weight = 1:2:0: expected FROM:TO:N with N",
    "sweep heavy.toml --vary body.wieght=1": "did you mean 'body.weight'?",
    "sweep heavy.toml --vary body.weight": "--vary = body.weight: expected KEY=FROM:TO:N or KEY=a",
    f"sweep heavy.toml {VARY} {VARY}": "expected body.weight once",
    f"sweep heavy.toml {VARY} --number single": "number = single: expected double",
    f"sweep heavy.toml {VARY} --tol 0.5": "expected between eps",
    f"sweep heavy.toml {VARY} --workers 0": "--workers = 0: expected 1 or more",
    f"sweep heavy.toml {VARY} --keep final --digits 20": "--digits = 20: expected --number instead",
    f"sweep heavy.toml {VARY} --keep final --method auto": "--method = auto: expected none with",
    f"sweep heavy.toml {VARY} --keep largest": "final, largest X, smallest X, first EVENT or lyap",
    f"sweep heavy.toml {VARY} --keep final --number quad": "double or extended, where numbers are",
    # -- new scenes
    "new x.toml --cone '3 cm,5 cm'": "--cone = 3 cm,5 cm: expected RADIUS,HEIGHT,MASS",
    "new x.toml --cone '3 cm,5 s,1 g'": "height = 5 s: expected a number (in s, not in m)",
    f"new x.toml --like {CASE} --spin 3": "no value together with --like",
    "new x.toml --like lagrange/nutatio": CASE,
    "new x.toml --tilt '3 m'": "in m, not in rad",
    "new x.toml --spin ''": "expected a number",
    "new cone": "polhode new cone.toml --cone RADIUS,HEIGHT,MASS",
    "new disc": "polhode new disc.toml --disc RADIUS,STEM,MASS",
    f"new {CASE}": f"polhode new FILE.toml --like {CASE}",
    "new top.toml": "does not exist yet",
    # -- where to write: never over what is read, and of the right kind
    "run scene.csv.json -o scene.csv": OTHER_FILE,
    "run top.toml -o x.npz -o x.npz": "x.npz: -o: expected each file once",
    "run top.toml -o y.npz -o same.npz": "same.npz: -o: expected each file once",  # a link to it
    "run top.toml -o link.csv": OTHER_FILE,
    f"sweep scene.csv.json {VARY} -o scene.csv": OTHER_FILE,
    "plot table.csv --what error --scene top.toml -o link.svg": OTHER_FILE,
    f"run {CASE} -o x.csv": "nowhere, where this link leads",
    f"run {CASE} -o nofolder/y.csv": "existing folder",
    f"run {CASE} -o .": "not a folder",
    f"run {CASE} -o": "expected",
    f"run {CASE} -o angles.csv": "expected another name: polhode did not write it",
    "orbit grioli/precession -o top.toml": "top.toml: file: expected another name: polhode did not",
    f"report {CASE} -o mine.md": "mine.md: file: expected another name: polhode did not write it",
    f"run {CASE} -o y.toml": "expected a name that ends in .csv",
    f"run {CASE} -o y.csv.gz": "expected a name that ends in .csv",
    f"run {CASE} -o - --json": "the results as JSON go to stdout",
    f"sweep heavy.toml {VARY} -o y.txt": "expected a name that ends in .csv or .json or .npz",
    f"sweep heavy.toml {VARY} -o no/y.npz": "expected an existing folder no",
    f"view {CASE} -o x.gif": f"ends in .html, or polhode plot {CASE} --what motion -o x.gif",
    f"view {CASE} -o x.svg": f"ends in .html, or polhode plot {CASE} --what W -o x.svg",
    f"view {CASE} -o x.txt": "-o: expected a name that ends in .html\n",
    f"plot {CASE} --what angles -o x.gif": ".svg, .png, .pdf; --what motion makes a film",
    # -- a film has no options of other figures
    f"plot {CASE} --what motion --title Mine -o x.gif": "--title = Mine: expected none, for a film",
    f"plot {CASE} --cmap viridis -o x.svg": "cmap = viridis: expected title",
    f"plot {CASE} --f-range 0:1 -o x.svg": "f_range = 0:1: expected title",
    f"plot {CASE} --cmap viridis -o x.gif": "--cmap = viridis: expected none, for a film",
    f"plot {CASE} --f-range 0:1 -o x.gif": "--f-range = 0:1: expected none, for a film",
    f"plot {CASE} --h-range 0:1 -o x.gif": "--h-range = 0:1: expected none, for a film",
    # -- names that are none: they were the current folder, and "Is a directory"
    "run ''": " = : expected a name\n",
    "run top.toml -o ''": "-o = : expected a name\n",
    "compare '' top.toml": " = : expected a name\n",
    "compare table.csv ''": " = : expected a name\n",
    "plot huge.toml --what momentum -o x.svg": OUT_OF_REACH,
    "plot huge.toml --what motion -o x.gif": OUT_OF_REACH,
    "view huge.toml -o x.html": OUT_OF_REACH,
    f"plot '' {ANGLES}": " = : expected a name\n",
    "plot table.csv --what omega --columns '' -o y.svg": "table.csv: header = : expected a header",
    "plot table.csv --what omega --columns P=p -o y.svg": "table.csv: --columns = P: expected a na",
    "check ''": " = : expected a name\n",
    f"section {GENERAL} --starts ''": " = : expected a name\n",
    # -- files are named as they were given, their folder too
    "run {folder}/future.toml": "polhode: {folder}/future.toml",
    "run {folder}/top.toml --at x": "polhode: {folder}/top.toml",
    "reference {folder}/top.toml --digits 99999": "polhode: {folder}/top.toml",
    "show {folder}/level.toml": "polhode: {folder}/level.toml",
    "levels {folder}/free.toml": "polhode: {folder}/free.toml",
    "orbit {folder}/top.toml --period -1": "polhode: {folder}/top.toml",
    "map {folder}/top.toml --tol 2": "polhode: {folder}/top.toml",
    "frequencies {folder}/top.toml --of x": "polhode: {folder}/top.toml",
    f"sweep {{folder}}/top.toml {VARY} --keep x": "polhode: {folder}/top.toml",
    "sweep {folder}/top.toml --vary body.moments[1]=1,-1": "polhode: {folder}/top.toml",
    "plot {folder}/top.toml --what omega --end 0 -o x.svg": "polhode: {folder}/top.toml",
    "compare {folder}/angles.csv {folder}/free.toml": "polhode: {folder}/angles.csv",
    "verify {folder}/scene.json": "polhode: {folder}/scene.json",
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text)
    for name, end in LINKS.items():
        Path(name).symlink_to(end)
    return tmp_path


def message_of(command: str) -> str:
    return ascii(command[:50]).strip("'")


@pytest.mark.parametrize("command", REFUSED, ids=message_of)
def test_bad_input_is_refused_in_one_line(command, folder, refusal):
    words = [word.replace("{folder}", str(folder)) for word in shlex.split(command)]
    assert REFUSED[command].replace("{folder}", str(folder)) in refusal(*words)


def test_every_verb_has_bad_input():
    assert {command.partition(" ")[0] for command in REFUSED} >= VERBS


def test_what_a_name_stands_for_is_a_verb():
    for name, meant in cli._MEANT.items():
        assert name not in VERBS
        words = meant.removeprefix("polhode ").replace(",", "").split()
        assert words[0] in (*VERBS, "--help", "--version"), name


@pytest.mark.parametrize(
    ("command", "variable", "value", "expected"),
    [
        (f"plot {CASE} {ANGLES}", "SOURCE_DATE_EPOCH", "x", "seconds since 1970, a whole number"),
        ("levels grioli/precession -o x.pdf", "SOURCE_DATE_EPOCH", "9" * 20, "seconds since 1970"),
    ],
)
def test_an_environment_that_is_none_is_refused(
    command, variable, value, expected, refusal, monkeypatch
):
    """matplotlib takes the date of a file from the environment."""
    monkeypatch.setenv(variable, value)
    said = f"polhode: environment: {variable} = {value}: expected {expected}"
    assert refusal(*command.split()).startswith(said)
