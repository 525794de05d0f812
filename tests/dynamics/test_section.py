"""Sections: starts on them, crossings against closed forms, curves of integrable tops."""

import json
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.dynamics import section as section_jobs
from polhode.dynamics import starts as geometry
from polhode.taylor import event_batches
from shared.motions import scene_of
from shared.tools import tiers

EPS = 2.0**-52
GENERIC = polhode.load("general/asymmetric-chaotic")
LEVEL = {"h": 3, "f": Fraction(1, 2)}


# -- states ----------------------------------------------------------------------------------------


def numbers_of(scene):
    """Moments, weight times centre and its direction, of a scene in principal axes."""
    body = scene.body
    moments, torque = (
        np.array([float(x) for x in v], np.longdouble) for v in (body.moments, body.torque)
    )
    return moments, torque, torque / np.sqrt(torque @ torque)


def off_level(scene, states, h, f, turning="momentum"):
    """The largest errors of h, f, |gamma|^2 and of the section's zero at states, in eps."""
    w, g = (states[..., k : k + 3].astype(np.longdouble) for k in (0, 3))
    moments, torque, arm = numbers_of(scene)
    G = w * moments
    zero = np.cross(arm, G if turning == "momentum" else w)
    errors = ((w * G).sum(-1) / 2 + g @ torque - float(h),)
    errors += ((G * g).sum(-1) - float(f), (g * g).sum(-1) - 1, (g * zero).sum(-1))
    return [float(np.abs(x).max() / EPS) for x in errors]


def bend(scene, states, by="momentum"):
    """The second derivative of |G|^2/2 or of the height, by differences of the vector equations."""
    moments, torque, _ = numbers_of(scene)

    def rate(x):
        turning = x[:, :3] * moments if by == "momentum" else x[:, :3]
        return (turning * np.cross(x[:, 3:], torque)).sum(1) * (1 if by == "momentum" else -1)

    w, g = states[:, :3], states[:, 3:]
    change = (np.cross(g, torque) - np.cross(w, w * moments)) / moments
    velocity = np.concatenate([change, np.cross(g, w)], axis=1)
    return (rate(states + 1e-5 * velocity) - rate(states - 1e-5 * velocity)) / 2e-5


@pytest.mark.parametrize(
    ("case", "f"),
    tiers(
        [("general/asymmetric-chaotic", f) for f in (0, Fraction(1, 2), -1, 2)],
        [("kovalevskaya/generic", 0)],
    ),
)
def test_states_are_on_level_and_section(case, f):
    scene, counted = polhode.load(case), 0
    moments, _, arm = numbers_of(scene)
    for extremum in ("max", "min"):
        options = {"h": 3, "f": f, "extremum": extremum, "accuracy": False}
        cut = polhode.section(scene, grid=(12, 12), crossings=1, **options)
        states = cut.start_states
        assert max(off_level(scene, states, 3, f)) < 48
        G = states[:, :3] * moments
        ratio = G @ arm / np.sqrt((G * G).sum(axis=1))
        assert np.abs(ratio - cut.starts[:, 1]).max() < 16 * EPS
        assert (bend(scene, states) < 0).all() == (extremum == "max")
        assert (bend(scene, states) > 0).all() == (extremum == "min")
        counted += len(states)
    assert counted >= 1.8 * 12 * 12  # y has two roots, four at some, none where h is too low


def count_of_states(extremum, l, ratio, **level):
    """How many states there are at a point of the section: what is said where one more is asked."""
    options = {"starts": [[l, ratio, 99]], "extremum": extremum, "crossings": 1}
    with pytest.raises(polhode.BadInput, match="a point with m") as fault:
        polhode.section(GENERIC, **options, **level)
    below = re.search(r"k below (\d+)", str(fault.value))
    return int(below[1]) if below else 0


def test_every_root_of_the_momentum_equation_is_found():
    """Sign changes on a fine grid of y, at 400 random points of ten random levels."""
    rng = np.random.default_rng(18)
    several = 0
    moments, torque, arm = (v.astype(float) for v in numbers_of(GENERIC))
    across_arm = np.cross(np.eye(3)[np.argmin(np.abs(arm))], arm)
    across_arm /= np.linalg.norm(across_arm)
    axes = np.array([across_arm, np.cross(arm, across_arm), arm])
    for _ in range(10):
        h, f = Fraction(int(rng.integers(10, 300)), 100), Fraction(int(rng.integers(0, 150)), 100)
        l = rng.uniform(0, 2 * np.pi, 40)
        sig = rng.choice([-1, 1], 40) * (1 - 10 ** rng.uniform(-3, 0, 40))
        counts = np.array(
            [
                sum(count_of_states(kind, *point, h=h, f=f) for kind in ("max", "min"))
                for point in zip(l.tolist(), sig.tolist(), strict=True)
            ]
        )
        across = np.sqrt(1 - sig * sig)
        e = np.stack([across * np.sin(l), across * np.cos(l), sig], axis=1) @ axes
        kappa = (e * e / moments).sum(1)[:, None]
        y = np.linspace(-4, 4, 16001)[None, :] + 1e-7
        R = np.hypot(float(f), y)
        value = kappa * R**2 / 2 - float(h)
        value += np.linalg.norm(torque) * (float(f) * sig[:, None] + y * across[:, None]) / R
        changes = np.diff(np.sign(value), axis=1) != 0
        jump = (f == 0) * changes[:, np.abs(y[0, 1:]) < 5e-4].sum(axis=1)
        assert (counts == changes.sum(axis=1) - jump).all()
        several += int((counts > 2).sum())
    assert several > 0


@pytest.mark.parametrize("extremum", ["max", "min"])
def test_heights_are_extremal(extremum):
    options = {"by": "height", "extremum": extremum, "accuracy": False}
    states = polhode.section(GENERIC, grid=(12, 12), crossings=1, **options, **LEVEL).start_states
    assert max(off_level(GENERIC, states, 3, Fraction(1, 2), "velocity")) < 64
    slopes = bend(GENERIC, states, "height")
    assert (slopes < 0).all() if extremum == "max" else (slopes > 0).all()


# -- crossings against closed forms ----------------------------------------------------------------


def spread(values):
    return float(np.max(np.max(values, axis=1) - np.min(values, axis=1)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "level", "low", "high"),
    [
        ("euler/attitude", {"h": 3, "f": Fraction(6, 5)}, 0.05, 2),
        ("goryachev-chaplygin/two-frequencies", {"h": 10}, 2, 100),
    ],
)
def test_curves_of_integrable_tops_close(case, level, low, high):
    """To the rounding of a state: the invariant's gradient, at most 200 of |state|, times eps."""
    scene = polhode.load(case)
    cut = polhode.section(scene, grid=(4, 4), crossings=300, accuracy=False, **level)
    assert cut.complete
    wide = cut.states.astype(np.longdouble)
    p, q, r, _, _, g3 = np.moveaxis(wide, -1, 0)
    G = wide[..., :3] * np.array([float(a) for a in scene.body.moments])
    if case.startswith("euler"):
        value = 2 * (G * wide[..., :3]).sum(-1) / (G * G).sum(-1)
    else:
        c = float(scene.body.torque[0] / scene.body.moments[2])
        value = r * (p * p + q * q) - c * p * g3
    assert low * EPS <= spread(value) < high * EPS


@pytest.mark.parametrize(
    ("by", "extremum"),
    tiers([("momentum", "max"), ("momentum", "min")], [("height", "max"), ("height", "min")]),
)
def test_crossings_are_extrema_of_the_kind_asked_for_on_the_level(by, extremum):
    options = {"by": by, "extremum": extremum, "accuracy": False, **LEVEL}
    cut = polhode.section(GENERIC, grid=(4, 4), crossings=90, **options)
    slopes = bend(GENERIC, cut.states.reshape(-1, 6), by)
    assert (slopes < 0).all() if extremum == "max" else (slopes > 0).all()
    assert cut.times[:, 0].min() > 0.1  # a start is no crossing
    errors = off_level(GENERIC, cut.states, 3, Fraction(1, 2), by)
    assert all(x < most for x, most in zip(errors, (4, 2, 1, 4), strict=True))


@pytest.mark.parametrize(
    ("by", "extremum", "mirrored"), [("momentum", "max", "max"), ("height", "min", "max")]
)
def test_a_weight_below_zero_is_one_along_the_opposite_centre(by, extremum, mirrored):
    """The same motion to the bit: extrema of |G| stay what they are, those of r0·gamma change."""
    centre = tuple(-x for x in GENERIC.body.centre)
    body = polhode.Body.of_moments(GENERIC.body.moments, centre, -GENERIC.body.weight)
    options = {"by": by, "starts": "scene", "crossings": 4, "accuracy": False}
    plain = polhode.section(GENERIC, extremum=extremum, **options)
    lifted = polhode.section(replace(GENERIC, body=body), extremum=mirrored, **options)
    assert np.array_equal(lifted.times, plain.times)
    assert np.array_equal(lifted.states, plain.states)
    assert np.array_equal(lifted.L_over_G, -plain.L_over_G)


@pytest.mark.slow
def test_a_crossing_at_the_seam_of_two_chunks_counts_once():
    """Chunks that end on the first crossing, to the last bit, and 1e-14 to either side of it."""
    options = geometry.cut_of(GENERIC, "momentum", "max", 3, Fraction(1, 2))
    on = options.on
    states = geometry.momentum_states(on, *geometry.cell_centres(4, 3), True).states
    zero = section_jobs.zero_of(on, "momentum")
    (job,) = section_jobs.jobs_of(on, zero, -1, 4, states)
    plain = event_batches.solve(job)
    for k in range(len(states)):
        for moved in (-1e-14, -1e-15, 0, 1e-15, 1e-14):
            chunk = float(plain.times[k, 0]) * (1 + moved)
            second = event_batches.solve(
                job._replace(
                    stretch=chunk, coefficients=job.coefficients[:1], starts=states[k : k + 1]
                )
            )
            assert np.abs(second.times[0] + second.rests[0] - plain.times[k]).max() < 1e-11


def test_an_expression_as_small_as_doubles_have_is_none_that_stays():
    """It was refused as a constant: a complex step of 1e-30 along it was 0."""
    options = {"starts": "scene", "crossings": 4, "accuracy": False}
    small, cut = (polhode.section(GENERIC, by=by, **options) for by in ("1e-300*q**3", "q"))
    assert np.abs(small.times - cut.times).max() < 1e-11


_TILTED = """schema = 1
title = "Tilted"
[body]
moments = [2, 1.5, 1]
centre = [0.3, 0.2, 0.5]
weight = 1
[start]
omega = [0.0, -1.75, 2.0]
gamma = ["2/3", "-1/3", "2/3"]
[run]
end = 20
"""


@pytest.mark.parametrize("times", [1, 2])
def test_no_triple_zero_is_taken_for_a_contact(times, tmp_path):
    """gamma3**3 is 0 to 1e-51 where gamma3 is: its rounding error there says nothing of a side."""
    (tmp_path / "tilted.toml").write_text(_TILTED)
    options = {"starts": "scene", "crossings": 12, "accuracy": False}
    flat, cut = (
        polhode.section(tmp_path / "tilted.toml", by=by, **options)
        for by in (f"{times}*gamma3**3", "gamma3")
    )
    assert np.abs(flat.times - cut.times).max() < 1e-5
    assert flat.outcomes == cut.outcomes


def test_flat_crossings_of_many_orbits_are_looked_at_each_with_its_own_numbers(tmp_path):
    """A crossing of the fifth order is looked at beside the others; its place may be any."""
    (tmp_path / "tilted.toml").write_text(_TILTED)
    options = {"starts": "scene", "crossings": 12, "accuracy": False, "workers": 1}
    cut = polhode.section(tmp_path / "tilted.toml", by="gamma3**5", **options)
    assert cut.counts.tolist() == [12]


def test_no_crossing_is_missed():
    """Against sign changes of D on dense output, on a chaotic orbit, while both have digits."""
    count = 48  # from there on doubles part: at 56 their crossings are 2 apart, and from quad's too
    cut = polhode.section(GENERIC, starts="scene", crossings=count, accuracy=False)
    end = float(cut.times[0, -1])
    run = polhode.integrate(GENERIC, at=np.linspace(0, end + 1e-3, 20_001)[1:])
    states = np.array(run.states, dtype=float)
    moments, _, arm = numbers_of(GENERIC)
    D = (states[:, 3:] * np.cross(arm, states[:, :3] * moments)).sum(axis=1)
    assert int(((D[:-1] > 0) & (D[1:] < 0)).sum()) == count
    assert (np.diff(cut.times) > 0).all()


# -- the same everywhere ---------------------------------------------------------------------------


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize("case", tiers(["general/asymmetric-chaotic"], ["kovalevskaya/generic"]))
def test_a_lane_does_not_depend_on_its_neighbours(case):
    """The Kovalevskaya top's orbits have each their own K^2, also one that takes a lane over."""
    starts = [[k / 2, 0.1 * k - 0.55] for k in range(11)]
    whole = polhode.section(case, starts=starts, crossings=40, **LEVEL)
    for k in (0, 4, 10):
        alone = polhode.section(case, starts=[starts[k]], crossings=40, **LEVEL)
        assert (alone.states[0] == whole.states[k]).all()
        assert (alone.times[0] == whole.times[k]).all()
        assert (alone.digits[0] == whole.digits[k]).all()
    backward = polhode.section(case, starts=starts[::-1], crossings=40, **LEVEL)
    assert (backward.states[::-1] == whole.states).all()


@pytest.mark.slow
@pytest.mark.usefixtures("parts_at_once")
def test_an_executor_and_parts_give_the_same(tmp_path, monkeypatch):
    options = {"grid": (10, 8), "crossings": 3, **LEVEL}
    plain = polhode.section(GENERIC, **options)
    with ThreadPoolExecutor(1) as pool:
        assert (polhode.section(GENERIC, executor=pool, **options).states == plain.states).all()
    folder = tmp_path / "x.npz.parts"
    polhode.section(GENERIC, parts=folder, **options)
    jobs = sorted(folder.glob("job-*.npz"))
    assert len(jobs) == 2
    jobs[0].unlink()
    jobs[1].write_bytes(b"torn")
    again = polhode.section(GENERIC, parts=folder, **options)
    assert (again.states == plain.states).all()
    with monkeypatch.context() as patch:
        patch.setattr("heyoka.taylor_adaptive_batch", None)  # nothing is left to be done
        assert (polhode.section(GENERIC, parts=folder, **options).states == plain.states).all()
    with pytest.raises(polhode.BadInput, match="the jobs of the same command"):
        polhode.section(GENERIC, parts=folder, grid=(9, 8), crossings=3, **LEVEL)


@pytest.mark.slow
def test_an_expression_in_turned_axes_and_other_units():
    """The same motion in axes turned by 90 degrees about the third, in a unit of 1024 seconds."""
    rotated = scene_of(
        "schema = 1\n[body]\nmoments = [1.5, 2, 1]\ncentre = [-0.2, 0.3, 0.5]\nweight = 1048576\n"
        "[start]\nomega = [-204.8, 307.2, 1126.4]\ngamma = [0, 0.6, 0.8]\n"
    )
    options = {"starts": "scene", "crossings": 12, "accuracy": False}
    plain = polhode.section(GENERIC, by="p - q/2 - 1/10", **options)
    cut = polhode.section(rotated, by="q/1024 + p/2048 - 1/10", **options)
    assert np.allclose(cut.times * 1024, plain.times, rtol=0, atol=1e-11)
    assert np.abs(plain.states[..., 0] - plain.states[..., 1] / 2 - 0.1).max() < 8 * EPS


# -- the verb and what it refuses ------------------------------------------------------------------


def test_the_scene_file_says_what_is_cut(capsys):
    text = GENERIC.source + '[section]\nby = "height"\ncrossings = 4\nstarts = [[1, 0, 0, -1]]\n'
    scene = scene_of(text)
    assert scene.section == polhode.SectionPlan("height", "max", 4, ((1, 0, 0, -1),))
    cut = polhode.section(scene, **LEVEL)
    assert cut.states.shape == (1, 4, 6)
    for fault, message in (
        ('extremum = "most"', "section.extremum = most: expected max, min"),
        ("crossings = 0", "section.crossings = 0"),
        ('by = "x"', "section.by = x: expected an expression"),
        ("starts = [1]", r"section.starts\[1\] = 1: expected an array"),
    ):
        with pytest.raises(polhode.BadInput, match=message):
            scene_of(GENERIC.source + "[section]\n" + fault + "\n")


def test_an_interrupted_section_ends_without_digits():
    """They take as long as the section: whoever interrupts does not wait for them."""

    def stop(fraction, count):
        raise KeyboardInterrupt

    cut = polhode.section(
        "general/asymmetric-chaotic", grid=(6, 6), crossings=20, workers=1, progress=stop
    )
    assert cut.interrupted
    assert np.isnan(cut.digits).all()
    assert cut.digits.shape == cut.times.shape
    printed = json.loads(cut.to_json())
    assert {*printed["columns"]["digits_expected"]} <= {None}
