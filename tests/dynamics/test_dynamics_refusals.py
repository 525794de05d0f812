"""What dynamics refuses, work without end or room too: in one line, and nothing is left behind."""

import re
import time
import tracemalloc

import numpy as np
import pytest

import polhode
from polhode.dynamics import section
from polhode.dynamics import starts as geometry
from polhode.dynamics.starts import cut_of
from polhode.scenes.vocabulary import STATE
from polhode.taylor import batches, variations
from polhode.taylor import event_batches as taylor
from polhode.taylor.event_batches import Watched
from shared.tools import change_memory, tiers

REGULAR = "general/asymmetric-regular"


# -- expressions with a pole ----------------------------------------------------------------------


@pytest.mark.parametrize("by", tiers(["1/q"], ["sqrt(q+1)"]))
def test_a_pole_or_a_root_on_the_way_is_one_line(refusal, by):
    words = ("section", REGULAR, "--by", by, "--grid", "2x2", "--crossings", "300", "-o", "x.npz")
    err = refusal(*words)
    said = f"by = {by}: expected an expression that is real and finite on all orbits"
    assert said in err
    l, ratio, t = map(float, re.findall(r"= (-?[\d.]+)(?:,| it|\n)", err)[-3:])
    scene = polhode.load(REGULAR)
    cut = polhode.section(scene, starts=[[l, ratio]], crossings=1, accuracy=False)
    q = _q(scene, cut.start_states[0], t)
    assert abs(q + (by != "1/q")) < 1e-4  # 0 there, or -1


def _q(scene, start, t) -> float:
    """q of a motion at a time, as the section's orbits go; the axes are principal ones."""
    body = scene.body
    plain = polhode.top(
        moments=body.moments,
        centre=body.centre,
        weight=body.weight,
        omega=start[:3].tolist(),
        gamma=start[3:].tolist(),
        normalise=True,
    )
    return float(polhode.integrate(plain, at=[t]).states[-1][1])


@pytest.mark.slow
def test_a_long_expression_is_compiled_in_time():
    by = "+".join(f"sin({k}*p)*q" for k in range(1, 76))
    began = time.process_time()
    assert polhode.section(REGULAR, by=by, grid=(2, 2), crossings=2).complete
    assert time.process_time() - began < 60  # a limit against hanging: it takes two


@pytest.fixture
def section_job():
    scene = polhode.load(REGULAR)
    plan = cut_of(scene, "momentum", "max", None, None)
    on = plan.on
    starts = geometry.momentum_states(on, np.array([1.5]), np.array([0.5]), True).states
    zero = section.zero_of(on, "momentum")
    (job,) = section.jobs_of(on, zero, -1, 5, starts)
    return job


def first_job(job, zero, end):
    """The first crossing of an expression by a section's first start."""
    watched = Watched(job.watched.names, STATE, zero, 128.0)
    return taylor.SearchJob(watched, 0, 1, end, 32.0, job.coefficients[:1], job.starts[:1])


def test_jobs_look_between_blocks_whether_to_stop(monkeypatch, section_job):
    """Each of them asked only between stretches, which have no longest time."""
    monkeypatch.setattr(batches, "BLOCK", 5)
    options: list[bool] = []

    def stop() -> bool:
        options.append(True)
        return len(options) == 3

    assert taylor.solve(section_job, stop).outcomes == (taylor.STOPPED,)
    assert len(options) == 3
    options.clear()
    names, own, tangent = section_job.watched.names, section_job.coefficients[:1], np.ones((1, 6))
    far = variations.TangentJob(names, own, section_job.starts[:1], tangent, 1e9, 1, None, (), 1.0)
    assert variations.solve(far, stop).last.tolist() == [0]
    options.clear()
    first = taylor.solve(first_job(section_job, "q-100", 1e9), stop)
    assert np.isnan(first.times).all()
    assert len(options) == 3


# -- sizes ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "least", "most"),
    [
        ("section R --grid 999x999 --crossings 1000000", 850_000, 988_799),
        ("section R --by height --grid 999x999 --crossings 1000000", 850_000, 998_001),
        ("map R --grid 1000x1000 --end 1000", 850_000, 990_781),
    ],
)
def test_a_large_grid_is_refused_before_its_states_are_found(refusal, words, least, most):
    tracemalloc.start()
    said = refusal(*words.replace("R", REGULAR, 1).split())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    text = re.search(r"= more than (\d+) (orbits|motions) .* in all; a coarser grid", said)
    assert text, said
    assert least < int(text[1]) < most
    assert peak < 48 * least  # of a state six doubles


def test_what_is_refused_for_its_size_says_the_largest_that_works(monkeypatch):
    change_memory(monkeypatch, 12_000)
    with pytest.raises(polhode.BadInput, match="2 orbits to 16 crossings: expected at most 30 "):
        polhode.section(REGULAR, starts=[[1.5, 0.5], [1.5, -0.5]], crossings=16)
    assert polhode.section(REGULAR, starts=[[1.5, 0.5], [1.5, -0.5]], crossings=15).complete
    with pytest.raises(
        polhode.BadInput, match="motions with 16 samples each: expected at most 500 "
    ):
        polhode.chaos_map(REGULAR, (8, 8), end=10)


def test_energies_at_the_edge_of_doubles_are_cut_or_refused():
    """Beyond, the powers of w in a Taylor step overflow: "not finite", and no crossing."""
    cut = polhode.section(REGULAR, h=10**30, f=0, starts=[[1.5, 0.5]], crossings=2)
    assert cut.complete
    with pytest.raises(polhode.BadInput, match=r"h = 1.0+e\+31: .* from 2e-30 to 2e\+30"):
        polhode.section(REGULAR, h=10**31, f=0, starts=[[1.5, 0.5]], crossings=2)


@pytest.mark.slow
def test_a_level_far_slower_than_the_scene_is_looked_at_as_often():
    """Looks at its tangent by the level's own rate; a ten-thousandth took minutes."""
    options = {"f": 0, "starts": [[1, 0.2]], "crossings": 3}
    cut, slow = (polhode.section("euler/prolate", h=h, **options) for h in (1, "1e-20"))
    assert slow.times == pytest.approx(1e10 * cut.times, rel=1e-12)
    assert slow.digits == pytest.approx(cut.digits, abs=1.2)


def test_a_body_out_of_reach_is_said_so():
    far = polhode.top(
        moments=["1+1e-100", 1, "1.5"], centre=[1, 2, 3], weight=1, gamma=[0, 0, 1], omega=[1, 0, 1]
    )
    with pytest.raises(polhode.BadInput, match="top: body: expected moments, gaps between them"):
        polhode.levels(far)


def test_energies_are_told_apart_at_any_f():
    """Two rotations were taken for one and its mirror image: three energies of six."""
    diagram = polhode.levels(REGULAR)
    regions = [[region for _, region in diagram.regions(f)] for f in (10**2, 10**16, 10**28)]
    assert regions[0] == regions[1] == regions[2]
    assert len(regions[0]) == 6


# -- What the doors and the verbs of dynamics refuse: one line that says so, and nothing is left ---

GENERIC = "general/asymmetric-chaotic"
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
        (GENERIC, {"tol": "loose"}, "tol[1] = loose: expected a number"),
        (GENERIC, {"workers": 0}, "workers = 0: expected a whole number, 1 or more"),
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
        (GENERIC, {"workers": 0}, "workers = 0: expected a whole number, 1 or more"),
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
        (GRIOLI, {"digits": 0}, "digits = 0: expected a whole number, 1 to 300"),
        (GRIOLI, {"digits": 301}, "digits = 301: expected a whole number, 1 to 300"),
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
    # what would be ignored
    "section R --grid 2x2 --starts scene": "grid = (2, 2): expected no grid together with starts",
    "section R --by p --extremum min": "extremum = min: expected none beside an expression, whose",
    "section R --grid 5x5 --crossings 999999": "expected at most 10000000 crossings in all",
    # the parts of a section that is refused at its end go
    "section R --by p+9 --grid 2x2 --crossings 3 -o x.npz": "that becomes zero; at the extrema",
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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("# a comment\n\n1/10, 0.2, x\n", "starts line 3[3] = x: expected a number"),
        ("# a comment\n", "starts = nothing: expected at least one start"),
    ],
)
def test_a_file_of_starts_is_refused_by_its_name_and_line(text, words, tmp_path):
    path = tmp_path / "starts.txt"
    path.write_text(text)
    with pytest.raises(polhode.BadInput) as fault:
        polhode.section("general/section", starts=str(path), crossings=2)
    assert str(fault.value).startswith(f"{path}: {words}")
