"""What the doors and the verbs of dynamics refuse: one line that says so, and nothing is left."""

from __future__ import annotations

import pytest

import polhode

GENERIC, REGULAR = "general/asymmetric-chaotic", "general/asymmetric-regular"
GRIOLI = "grioli/precession"
GRIDS = [
    ("lagrange/nutation", {"grid": grid}, "grid = ")
    for grid in ((3, 3, 3), (3,), 3, (3, 0), (3.0, 3), "no")
]

#: Of each door: a scene, what is asked, and what is said.
DOORS = {
    polhode.chaos_map: [
        *GRIDS,
        (GENERIC, {"end": 0}, "a time above 0"),
        (GENERIC, {"h": -1}, "the least energy at f"),
        (GENERIC, {"by": "p"}, "momentum or height, for a map"),
        (GENERIC, {"tol": 1e-20}, "a tolerance from"),
        (GENERIC, {"vary": {"start.omga[1]": [1]}}, "a number of the scene"),
        (
            GENERIC,
            {"vary": {"start.omega[1]": [1], "start.omega[2]": [1]}, "h": 3},
            "no grid, section or level",
        ),
    ],
    polhode.section: [
        *GRIDS,
        (GENERIC, {"h": -1}, "h = -1: expected above -0.1037"),
        (GENERIC, {"h": 1, "f": 3}, "the least energy at f = 3"),
        (GENERIC, {"by": "1"}, "an expression that changes along the motion"),
        (GENERIC, {"by": "gamma1**2 + gamma2**2 + gamma3**2"}, "this one is constant"),
        (
            GENERIC,
            {"by": "p + 10", "grid": (2, 2)},
            "an expression that becomes zero; at the extrema",
        ),
        (GENERIC, {"by": "x"}, "by = x: expected momentum, height, or an expression"),
        (GENERIC, {"extremum": "most"}, "extremum = most: expected max or min"),
        (GENERIC, {"starts": [[1, 1]]}, "L/G between -1 and 1"),
        (GENERIC, {"starts": [[1, 0.2, 1]]}, "a point with maxima of |G|: k below 1"),
        (GENERIC, {"starts": [[0.471, 0.925]]}, "at this l they lie from L/G"),
        (GENERIC, {"starts": [[1]]}, "[l, L/G] or [l, L/G, k]"),
        (GENERIC, {"starts": []}, "at least one start"),
        (GENERIC, {"by": "height", "starts": [[1, 0, 0]]}, "gamma of length 1"),
        (
            GENERIC,
            {"by": "height", "starts": [[1, 0, 0, 1]], "extremum": "min", "h": 2, "f": 2},
            "other kind",
        ),
        (GENERIC, {"crossings": 0.5}, "crossings = 0.5: expected a whole number"),
        (
            "staude/unstable",
            {"starts": "scene"},
            "a permanent rotation, which crosses no section",
        ),
    ],
    polhode.orbit: [
        ("staude/stable", {}, "start: expected a motion: this is a permanent rotation"),
        ("hess/general", {}, "multiplies errors by"),  # too unstable for double
        (GRIOLI, {"h": -5}, "h = -5: expected above -0.8"),
        (GRIOLI, {"digits": 0}, "digits = 0: expected a whole number, 1 to 4000"),
        (GRIOLI, {"period": -1}, "period = -1: expected a time above 0"),
        (GRIOLI, {"period": 3}, "start: expected a start nearer to a periodic orbit"),
        (GRIOLI, {"returns": 0}, "returns = 0: expected a whole number, 1 to 1000"),
        ("euler/no-gamma", {}, "start.gamma: expected a unit vector"),
    ],
    polhode.orbit_family: [
        (GRIOLI, {"by": "x", "to": 3}, "by = x: expected h, f"),
        (GRIOLI, {"by": "h", "to": "63/74"}, "to = 63/74: expected another h"),
        (GRIOLI, {"by": "h", "to": "a"}, "to[1] = a: expected a number"),
        ("euler/largest-axis", {"by": "h", "to": 10}, "an orbit of one family"),  # a torus
    ],
    polhode.orbit_search: GRIDS,
}


@pytest.mark.parametrize(
    ("door", "scene", "options", "said"),
    [(door, *row) for door, rows in DOORS.items() for row in rows],
)
def test_a_door_refuses_in_one_line(door, scene, options, said):
    with pytest.raises(polhode.BadInput) as caught:
        door(scene, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


#: Commands, R: the regular top, and what is said; o: the output's place.
VERBS = {
    "section R --grid 99999x99999": "grid = 99999x99999: expected at most 1000000 cells",
    "orbits R --grid 99999x99999": "grid = 99999x99999: expected at most 1000000 cells",
    "map R --grid 9999x9999": "grid = 9999x9999: expected at most 1000000 cells",
    "section R --h 1e60 --f 0": "h = 1.0000000000000000e+60: expected of a size that doubles have",
    "map R --h 1e60 --f 0": "h = 1.0000000000000000e+60: expected of a size that doubles",
    "orbits R --grid 2x2 --h 1e60 --f 0": "h = 1.0000000000000000e+60: expected of a size",
    "levels R --h-range=-1e308:1e308 -o l.svg": "--h-range = -1e308:1e308: expected A:B, two nu",
    "section R --h 1e400 --f 0": "h = 1.0000000000000000e+400: expected of a size",
    "section euler/prolate --h 1e-130 --f 0": "h = 1.0000000000000000e-130: expected of a",
    "orbit R --period 1e-300": "period = 1e-300: expected one near 0.89 or longer",
    "levels R --f-range 1e300:1e301 --h-range 1e300:1e301 -o l.svg": "f = 1.000000000000000",
    "section R --f 1e300 --h 1e300": "h = 1.0000000000000000e+300: expected above",
    "map R --f 1e300 --h 3": "h = 3: expected above 2.5000000000000000e+599, below which",
    "section R --grid 5x5 --crossings 999999": "expected at most 10000000 crossings in all",
    # the parts of a section that is refused at its end go
    "section R --by p+9 --grid 2x2 --crossings 3 -o x.npz": "an expression that becomes zero",
    # an expression without a value at a start is not called constant
    **{
        f"section R --by {by} --grid 2x2 --crossings 3": (
            "real and finite on all orbits; on the one from l = 1.5708"
        )
        for by in ("sqrt(p-5)", "sqrt(q)", "1/(q-q)")
    },
    "frequencies euler/attitude --of x": "of = x: expected p+iq",
    "frequencies euler/attitude --of r,": "--of = r,: expected names with commas between",
    "frequencies euler/no-gamma --of gamma3": "a scene with start.gamma",
    "frequencies euler/attitude --end 0": "end = 0: expected a time other than 0",
    "frequencies euler/attitude --end 1e9": "more samples take too long",
    "levels euler/no-gamma": "start.gamma: expected a unit vector",
    "levels euler/attitude --f-range 3:1 -o x.svg": "--f-range = 3:1: expected A:B with A below B",
    "levels euler/attitude --h-range 3 -o x.svg": "--h-range = 3: expected A:B, two nu",
    "levels euler/attitude -o x.txt": "x.txt",
    "family G --by x --to 3": "by = x: expected h, f",
    "family G --by h --to 1:2:1": "to[1] = 1:2:1: expected a number",
    "family G --by h --to 1 --digits 20": "option = --digits: expected",
    "orbits G --grid 0x3": "--grid = 0x3: expected NxM",
}


@pytest.mark.parametrize("words", VERBS)
def test_a_verb_refuses_in_one_line_and_leaves_nothing(words, refusal):
    command = words.replace(" R", f" {REGULAR}").replace(" G", f" {GRIOLI}")
    assert VERBS[words] in refusal(*command.split())
