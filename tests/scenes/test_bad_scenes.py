"""Scenes that cannot be: key and bad value -> one line, from Python and from files."""

from decimal import Decimal

import numpy as np
import pytest

import polhode
from polhode import BadInput
from shared.motions import scene_of

FREE = {"moments": [1, 2, 2.5], "omega": [0.1, 1, 0]}
ROD = {"shape": "rod", "mass": 1, "height": 1}
SYMMETRIC = [[2, 0.1, 0], [0.1 + 1e-14, 2, 0], [0, 0, 3]]
SINGLE = np.float32([[2, 0.1, 0], [0.100001, 2, 0], [0, 0, 3]])
SIX = "[[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], signs unchanged"


def inertia(*rows):
    return {"moments": None, "inertia": rows[0] if len(rows) == 1 else [*rows, [0, 0, 3]]}


LEVEL = {"moments": [1, 1, "1/2"], "centre": [0, 0, 1], "weight": 1, "omega": None}
#: What is given beside, or instead of, a body of three moments that turns: words of the line.
NUMBERS = [
    ({"mass": 1}, "body.g: expected g or weight together with mass; 0 for none"),
    ({"g": 1}, "body.mass: expected a number, with g"),
    ({"mass": 0, "g": 1}, "body.mass = 0: expected a mass above 0"),
    ({"mass": 1, "g": 1, "weight": 1}, "body.weight = 1: expected only one of weight and g"),
    ({"mass": 1, "g": 1}, "body.centre: expected three numbers, since weight is not 0"),
    ({"about": "centre"}, "body.mass: expected a value, with about"),
    ({"about": "centre", "mass": 1, "g": 0}, "body.centre: expected a value, with about"),
    ({"about": "the tip"}, "body.about = the tip: expected 'fixed point' or 'centre'"),
    (
        {"moments": [1, 2, 4], "about": "centre", "mass": 1, "g": 0, "centre": [0, 0, 9]},
        "sum of the others",  # carried far enough away it would look like one
    ),
    ({"parts": [{"shape": "rod"}], "moments": None}, "body.parts[1].mass: expected a value"),
    ({"parts": [ROD]}, "body.moments = [1, 2, 2.5]"),
    ({"moments": None, "parts": [ROD], "g": 0}, "parts: expected parts of positive principal mom"),
    ({"moments": None, "parts": [3]}, "body.parts[1] = 3: expected a Part, or a mapping"),
    ({"moments": None, "parts": [{"shap": 3}]}, "did you mean 'shape'?"),
    ({"moments": None, "parts": 2.5}, "body.parts = 2.5: expected a list of Part"),
    ({"angles": [0, 0, 0], "gamma": [0, 0, 1]}, "start.angles = [0, 0, 0]: expected no value"),
    ({"rates": [0, 0, 0]}, "start.omega = [0.1"),
    ({"quaternion": [1, 1, 0, 0]}, "length exactly 1, or normalise = true"),
    ({"quaternion": [0, 0, 0, 0], "normalise": True}, "a vector that is not zero"),
    ({"quaternion": [1, 0, 0]}, "an array of 4 numbers"),
    ({"quaternion": [1, 0, 0, 0], "psi": 1}, "start.psi = 1: expected no value together with qu"),
    ({"omega": [1, 2, "x"]}, "start.omega = x: expected a number"),
    ({"omega": [1, 2, float("inf")]}, "start.omega = inf: expected a number"),
    ({"omega": np.array(3.0)}, "start.omega = 3.0: expected an array of 3 numbers"),
    ({"samples": 3.5, "end": 1}, "run.samples = 3.5: expected a whole number"),
    ({"events": [3]}, "events[1] = 3: expected an Event, or a mapping of its keys"),
    ({"outputs": [3]}, "run.outputs = 3: expected a text"),
    ({"normalise": np.zeros(3)}, "start.normalise = [0. 0. 0.]: expected True or False"),
    ({"name": 3}, "top: name = 3: expected text"),
    ({"title": np.array(3.0)}, "title = 3.0: expected a text"),
    ({"title": "\ud800"}, "title = ?: expected a text of at most 10000 whole"),
    ({"title": "x" * 20_000}, "expected a text of at most 10000 whole"),
    ({"at": (k for k in (2, 1))}, "run.at[2] = 1: expected times of one sign"),
    ({"moment": [2, 2, 1]}, "moment = [2, 2, 1]: ; did you mean 'moments'"),
    ({"events": [{"name": "x", "zero": "p", "stopp": True}]}, "events[1].stopp; mean 'stop'"),
    ({"events": [polhode.Event("section:gama1")]}, "events[1].name = gama1: ; mean 'gamma1'"),
    ({"events": [polhode.Event("x", y) for y in "pq"]}, "events[2].name = x: ; a name of its own"),
    ({"omega": [None, 0, 1]}, "start.omega = None: expected a value"),
    ({"samples": Decimal("3.5"), "end": 1}, "run.samples = 3.5: expected a whole number from 2"),
    # more than rounding, with its amount
    (inertia(SYMMETRIC), "[1][2] and [2][1] differ by 1e-14"),
    (inertia(["2", "0.1", 0], ["0.1+1e-17", "2", 0]), "differ by 1e-17"),
    (inertia(SINGLE), "differ by 9.98e-07"),
    (inertia([2, 0.5, 0], [-0.5, 2, 0]), "differ by 1; off the diagonal stand minus"),
    (inertia([1, 0.5, 0], [0.5, 1, 0]), "they are 0.5, 1.5, 3, too much by 1; off"),
    (inertia([1, 2, 0], [2, 1, 0]), "positive principal moments: they are 3, 3, -1;"),
    ({"moments": [0.1, 0.2, 0.3 + 1e-14]}, "they are 0.1, 0.2, 0.3, too much by 9.9"),
    ({"moments": [1, 2, "3.0000000000000000001"]}, "they are 1, 2, 3, too much by 1e-19"),
    (
        {"moments": [1, 2, 4], "centre": [0, 0, 1], "weight": 1, "gamma": [0, 0, 1]},
        "too much by 1; with a torque of the weight no other body moves so",
    ),
    ({"moments": [1, 2, -3]}, "positive principal moments: they are 1, 2, -3"),
    ({"gamma": [0.6, 0, 0.8 + 1e-14]}, "its square is 1 + 1.6e-14"),
    ({"gamma": ["0.6", 0, "0.8-1e-17"]}, "its square is 1 - 1.6e-17"),
    ({"gamma": np.float32([0.6, 0, 0.8])}, "normalise"),
    ({"quaternion": [0.5, 0.5, 0.5, 0.4]}, "its square is 1 - 0.09"),
    # six numbers of URDF, and three moments
    *((inertia(x), SIX) for x in ([1, 0, 0, 2, 0, 2], {"ixx": 1, "iyy": 2}, 5, [[1, 0, 0]])),
    (inertia([2, 3, 4]), "body.inertia = [2, 3, 4]: expected moments = [A, B, C], or a 3 x 3"),
    # momenta that no start has
    (LEVEL | {"h": 3, "f": "6/5", "p_phi": 2}, "start.h = 3: expected as much energy as f and"),
    (
        LEVEL | {"h": 3, "f": 9, "p_phi": 1, "gamma": [1, 0, 0]},
        "start.h = 3: expected at least 83/2",
    ),
    (
        LEVEL | {"h": 9, "f": 2, "p_phi": 2, "gamma": [0, 0, 1]},
        "start.gamma = [0, 0, 1]: expected th",
    ),
    (LEVEL | {"h": 9, "f": 2, "p_phi": 2}, "start.gamma: expected an orientation, since this end"),
    (LEVEL | {"h": 9, "p_phi": 2}, "start.f: expected a number"),
    (LEVEL | {"p_phi": 2, "f": 1}, "start.h: expected a number"),
    (LEVEL | {"p_phi": 2, "omega": [1, 1, 1], "gamma": [0, 0, 1]}, "start.h: expected a number"),
    (
        LEVEL | {"h": 9, "f": 2, "p_phi": 1, "normalise": True},
        "start.normalise = true: expected no",
    ),
    (LEVEL | {"moments": [3, 2, 1], "h": 9, "f": 2, "p_phi": 1}, "an orientation, since only"),
    (
        LEVEL | {"h": 9, "f": 2, "p_psi": 1},
        "p_psi = 1: expected f, the momentum about the vertical",
    ),
    (LEVEL | {"E": 9, "f": 2, "p_phi": 1}, "E = 9: expected h, the energy"),
    # units
    ({"omega": ["5 cm", 0, 0]}, "start.omega; in m, not in rad/s"),
    ({"moments": ["2 kg", 2, 1]}, "body.moments; in kg, not in kg"),
    ({"centre": [0, 0, "1 s"]}, "body.centre; in s, not in m"),
    ({"weight": "1 kg"}, "body.weight; in kg, not in N"),
    ({"gamma": ["90 deg", 0, 0]}, "start.gamma; no unit belongs"),
    ({"end": "10 m"}, "run.end; in m, not in s"),
    ({"units": "cgs"}, "units = cgs: expected SI"),
]


#: Lines of a file whose value is an expression without quotes: what is said of it.
BARE = [
    ("omega = [1/3, 0, 0]", "omega = 1/3: expected it in quotes, as every expression"),
    ("omega = [0, sqrt(2)/2, 1]", 'omega = sqrt(2)/2: ; with a unit: "sqrt(2)/2"'),
    ("omega = [\n1e-3/2,\n0, 1]", 'line 3 = 1e-3/2: ; "1e-3/2"'),
    ("angles = [0, -pi/6, 0] # x", 'angles = -pi/6: ; "-pi/6"'),
    ("angles = [30 deg, 0, 0]", 'angles = 30 deg: ; "30 deg"'),
    ("end = 10 s", 'end = 10 s: ; "10 s"'),
    ("omega = [1, 2, 1+2]", 'omega = 1+2: ; "1+2"'),
    ("omega = [1, 2, -(1+2)*3 ]", 'omega = -(1+2)*3: ; "-(1+2)*3"'),
    ("omega = [2^3, 0, 0]", 'omega = 2^3: ; "2^3"'),
    ("omega = [.5, 0, 0]", 'omega = .5: ; ".5"'),
    ("omega = [0, 5., 0]", 'omega = 5.: ; "5."'),
    ('omega = [3 + "x", 0, 0]', "file: expected TOML (Unclosed array"),
    ("omega = [0 0 1]", "file: expected TOML (Unclosed array"),
    ("omega = [1, 0, 0", "file: expected TOML (Unclosed array"),
    ('title = "a top, 3 cm" tall', "file: expected TOML (Expected newline"),
    ("end = 1,5 # [5 cm]", "file: expected TOML (Expected newline"),
    ("end = 3 samples = 1/3", 'end = 3 samples: ; "3 samples"'),
    ("end = 1 # [1/3]\nend = = 1", "file: expected TOML (Invalid value (at line 3"),
]


@pytest.mark.parametrize(("line", "words"), BARE)
def test_an_expression_without_quotes_is_named(line, words):
    """An unclosed array, it said."""
    with pytest.raises(BadInput) as fault:
        scene_of(f"[start]\n{line}\n", "x.toml")
    assert all(word in line_of(fault) for word in f"x.toml; {words}".split("; "))


def line_of(fault) -> str:
    line = str(fault.value)
    assert line.isprintable()
    assert "expected " in line
    assert len(line) < 1000
    return line


@pytest.mark.parametrize(("keys", "words"), NUMBERS, ids=[x[1][:40] for x in NUMBERS])
def test_what_cannot_be_is_refused_by_the_name_of_its_key(keys, words):
    with pytest.raises(BadInput) as fault:
        polhode.top(**(FREE | keys))
    assert all(word in line_of(fault) for word in words.split("; "))


PARTS = [
    ({"shape": "cube", "mass": 1}, "shape = cube: expected box, cylinder"),
    ({"shape": "cone", "mass": 0, "radius": 1, "height": 1}, "mass = 0: expected a mass above"),
    ({"shape": "cone", "mass": 1, "radius": 1}, "height: expected a value for shape cone"),
    ({"shape": "cone", "mass": 1, "radius": 0, "height": 1}, "radius = 0: expected a length"),
    ({"shape": "rod", "mass": 1, "height": -1}, "height = -1: expected a length above 0"),
    ({"shape": "disc", "mass": 1, "radius": 1, "height": 1}, "nothing: shape disc has radius"),
    ({"shape": "disc", "mass": 1, "radius": 1, "inner": 2}, "inner = 2: expected a radius no"),
    ({"shape": "box", "mass": 1, "size": (1, 2)}, "three numbers"),
    ({"shape": "box", "mass": 1, "size": (1, 2, 3), "axis": "x"}, "shape box has no axis"),
    ({"shape": "rod", "mass": 1, "height": 1, "axis": "w"}, "axis = w: expected z, x, y"),
    ({"shape": "point", "mass": "50 cm"}, "in m, not in kg"),
]


@pytest.mark.parametrize(("keys", "said"), PARTS, ids=[x[1] for x in PARTS])
def test_a_part_that_cannot_be_is_refused(keys, said):
    with pytest.raises(BadInput, match=f"^Part: .*{said}"):
        polhode.Part(**keys)
    with pytest.raises(BadInput, match=rf"body\.parts\[1\].*({said}|numbers)"):
        polhode.top(**(FREE | {"moments": None, "parts": [keys], "g": 0}))


def test_parts_that_are_not_the_bodys_are_refused():
    cone = polhode.Part("cone", 1, radius=1, height=1)
    body = polhode.Body.of_parts([cone], weight=1)
    with pytest.raises(BadInput, match="parts of this inertia and centre"):
        polhode.Body(body.inertia, (0, 0, 1), 1, (cone,))
    with pytest.raises(BadInput, match="one of g and weight"):
        polhode.Body.of_parts([cone])
    with pytest.raises(BadInput, match="at least one Part"):
        polhode.Body.of_parts([], g=1)


# -- files ------------------------------------------------------------------------------------

BASE = """
schema = 1
[body]
moments = [2, 3, 4]
[start]
omega = [0.3, -0.4, 1.1]
gamma = [0, 0, 1]
[run]
end = 1
"""


def base(**changes: str) -> str:
    """BASE with lines replaced: ``moments="inertia = ..."``; "" leaves the line out."""
    lines = []
    for line in BASE.splitlines():
        lines.append(changes.pop(line.split(" =")[0].strip("[]"), line))
    assert not changes
    return "\n".join(lines)


def more(text):
    """One line more, of the run or in a table behind it."""
    return {"end": f"end = 1\n{text}"}


def of_schema(line):
    return {"schema": f"schema = 1\n{line}"}


def of_body(lines):
    return {"moments": lines}


HEAVY = "moments = [2, 1.5, 1]\ncentre = [0.3, 0.2, 0.5]\nweight = 1"


def level(start, gamma='gamma = ["3/5", 0, "4/5"]', body=HEAVY):
    return {"moments": body, "omega": start, "gamma": gamma}


ALONG = "gamma = [0.3, 0.2, 0.5]\nnormalise = true"
RATES = "angles = [0, 1, 0]\nrates = [1, 0, 0]"

#: Lines that are others in a good scene: words of the line.
FILES = [
    ({"schema": ""}, "schema; 1"),
    ({"schema": "schema = 2"}, "schema = 2: expected 1"),
    (of_schema("titel = 'x'"), "titel = x; did you mean 'title'"),
    (of_schema("title = 3"), "title = 3; a text"),
    (of_schema("tags = [0.50]"), "tags = 0.50; a text"),
    (of_schema("events = 3"), "events = 3; [[events]]"),
    (of_schema("moments = [1]"), "moments = [1]: expected no such key here: it belongs in [body]"),
    (of_schema("omega = [1]"), "omega = [1]: expected no such key here: it belongs in [start]"),
    (of_schema("end = 3"), "end = 3: expected no such key here: it belongs in [run]"),
    (of_schema("mass = 3"), "mass = 3: ; it belongs in [body] or [[body.parts]]"),
    ({"body": "[bdy]"}, "bdy; did you mean 'body'"),
    (of_body("momens = [1,1,1]"), "body.momens = [1, 1, 1]; did you mean 'moments'"),
    (of_body("weight = 0"), "body.moments; inertia"),
    (of_body("moments = [2, 3]"), "body.moments = [2, 3]; an array of 3 numbers"),
    (of_body("moments = [2, 3, -0.10]"), "body.moments = [2, 3, -0.10]; positive"),
    (of_body("moments = [2, 3, nan]"), "body.moments = nan; finite"),
    (of_body("moments = [2, 3, true]"), "body.moments = true; a number"),
    (of_body("moments = [2, 3, 'sqrt(-1)']"), "body.moments = sqrt(-1); negative"),
    (of_body("moments = [2, 3, 'sqr(9)']"), "sqr(9); did you mean 'sqrt'"),
    (of_body("moments = [2, 3, 1e9999]"), "body.moments = 1e9999; exponent"),
    (of_body("moments = [1,1,1]\ninertia = [[1]]"), "body.inertia = [[1]]; only one"),
    (of_body("inertia = [[2,0,0],[0,'x',0],[0,1,2]]"), "body.inertia[2] = x; a number"),
    (of_body("moments = [1,1,1]\nweight = 1"), "body.centre; weight"),
    ({"omega": ""}, "start.omega; momentum; angles"),
    ({"omega": "omega = [1,2,3]\nmomentum = [1,2,3]"}, "start.omega; one of"),
    ({"omega": "omega = [1,2,3]\nrates = [1,2,3]"}, "start.omega; no value together with"),
    ({"omega": "omega = [1,2,3]\nend = 3"}, "start.end = 3: ; it belongs in [run]"),
    ({"omega": "omega = [1,2,3]\ntitle = 'x'"}, "start.title = x: ; belongs in the top level"),
    ({"omega": "angles = [0, 1e3000, 0]", "gamma": "rates = [0, 0, 0]"}, "start.angles = [0, 1e3"),
    ({"gamma": "gamma = [0, 0, 1.0000001]"}, "start.gamma; length exactly 1; normalise"),
    ({"gamma": "gamma = [0,0,1]\nnormalise = 1"}, "start.normalise = 1; true or false"),
    ({"gamma": "gamma = ['sqrt(1/3)+1e-900', 'sqrt(1/3)', 'sqrt(1/3)']"}, "length"),
    ({"gamma": "", "moments": HEAVY}, "start.gamma"),
    ({"gamma": "", **more("outputs = ['angles']")}, "run.outputs = angles"),
    ({"end": "end = 0"}, "run.end = 0; other than 0"),
    ({"end": "samples = 3"}, "run.end; samples"),
    (more("samples = 1"), "run.samples = 1; from 2"),
    (more("samples = true"), "run.samples = true; a whole number"),
    (more("samples = 10.0"), "run.samples = 10.0; a whole number"),
    (more("at = [1]"), "run.end = 1; no value together with at"),
    ({"end": "at = []"}, "run.at = []; at least one"),
    ({"end": "at = [1, 2, 2]"}, "run.at[3] = 2; monotone"),
    ({"end": "at = [1, -2]"}, "run.at; one sign"),
    ({"end": "at = ['sqrt(6)', 'sqrt(2)*sqrt(3)']"}, "run.at[2] = 2.449489742783178; mono"),
    (more("form = 'principle'"), "run.form = principle; mean 'principal'"),
    (more("outputs = ['angels']"), "run.outputs = angels; mean 'angles'"),
    (more("[[events]]\nzerro = 'p'"), "events[1].zerro = p; mean 'zero'"),
    (more("[[events]]\nzero = 'gama1'"), "events[1].zero = gama1; 'gamma1'"),
    (more("[[events]]\nzero = 'p/0'"), "events[1].zero = p/0; division"),
    (more("[[events]]\nname = 'flop'"), "events[1].zero: ; mean 'flip'"),
    (more("[[events]]\nzero = 'p'\ndirection = 'fall'"), "direction = fall; mean 'falling'"),
    (more("[[published]]\nt = 1"), "published[1].quantity; a text"),
    (more("[reference]\nkind = 'eular'"), "reference.kind = eular; 'euler'"),
    (more("[reference]\nkind = 'two-precisions'"), "two-precisions: expected auto, or certified"),
    (more("[expect]\ndoubel = [1, 2]"), "expect.doubel; mean 'double'"),
    (more("[expect]\nmp = [2, 1]"), "expect.mp = [2, 1]; least"),
    (more("[expect]\nmp = [1, '1e3000']"), "expect.mp = [1, 1e3000]; least"),
    (more("end = 2"), "TOML; overwrite"),
    ({"end": "end = " + "9" * 5000}, ""),  # refused by TOML's reader or as too large
    ({"end": "end = 0x" + "f" * 5000}, "run.end; too large"),
    ({"end": "end = " + "[" * 5000}, "TOML; nested"),
    ({"end": "a." * 900 + "b = 1"}, "run.a; did you mean 'at'"),
    # a start on a level
    (level("h = 0.1\nf = 0.5"), "start.h = 1/10: expected at least 4569/6800"),
    (level("f = 0.5"), "start.h: expected a number"),
    (level("h = 3"), "start.f: expected a number"),
    (level("h = 3\nf = 0.5\nsign = 'plus'"), "start.sign = plus: expected + or -"),
    (level("h = 3\nf = 0.5\nsign = 1"), "start.sign = 1: expected a text"),
    (level("h = 3\nf = 0.5\nomega = [1, 0, 0]"), "start.omega = [1, 0, 0]: expected no value"),
    (level("h = 3\nf = 0.5\nangles = [0, 1, 0]"), "start.angles; no value together with gamma"),
    (level("h = 3\nf = 0.5", ""), "start.gamma: expected a unit vector, since"),
    (level("h = 3\nf = 0", RATES), "start.h; no value together with rates"),
    (level("h = 3\nf = 0.5", 'gamma = ["3/5", 0, 1]'), "start.gamma; length exactly 1"),
    (level("h = 9\nf = 0.5", ALONG), "start.gamma; not along the centre of mass"),
    (
        level("h = 3\nf = 0.5", "gamma = [0, 0, 1]", "moments = [2, 1.5, 1]"),
        "not along the third principal axis",
    ),
]


@pytest.mark.parametrize(("change", "words"), FILES, ids=[x[1][:40] for x in FILES])
def test_a_refusal_names_key_value_and_what_was_expected(change, words):
    with pytest.raises(BadInput) as fault:
        scene_of(base(**change), "top.toml")
    line = line_of(fault)
    assert line.startswith("top.toml: ")
    assert all(word in line for word in words.split("; ")), line


def test_what_is_not_a_scene_file_is_refused(tmp_path):
    path = tmp_path / "top.toml"
    for content in (b"\xff\xfe", b"\0", BASE.encode("utf-16"), b"#" * (100_001)):
        path.write_bytes(content)
        with pytest.raises(BadInput, match=r"top\.toml: file: expected"):
            polhode.load(path)
    for absent in (tmp_path, tmp_path / "none.toml"):
        with pytest.raises(BadInput, match=r"readable|a path"):
            polhode.load(absent)
