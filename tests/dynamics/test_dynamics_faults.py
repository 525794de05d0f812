"""The table of faults of dynamics: what once was wrong, a row each, by users' doors."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from shared.motions import scene_of

# -- frequencies -----------------------------------------------------------------------------------

FIVE = [0.5, 1.0, 1.7, 2.3, 3.1]
STEP = 0.1


def cosines(rates, t):
    """Pure cosines of one size, at phases of their own."""
    return sum(np.cos(rate * t + k) for k, rate in enumerate(rates))


def sampled(path, columns, decimals=None):
    """A CSV file of columns by name; of its times so many decimals, all digits unless given."""
    rows = [",".join(columns)]
    for t, *values in zip(*columns.values(), strict=True):
        first = repr(float(t)) if decimals is None else f"{t:.{decimals}f}"
        rows.append(",".join([first, *(repr(float(x)) for x in values)]))
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_signal_with_a_gap_is_refused_by_its_row(tmp_path):
    """It was called a column that is not there."""
    t = STEP * np.arange(100)
    gamma3 = [*np.cos(t[:50]), np.nan, *np.cos(t[51:])]
    path = sampled(tmp_path / "gap.csv", {"t": t, "gamma3": gamma3, "p": np.sin(t)})
    words = r"gamma3 at t = 5: expected a number in each row of a signal \(row 51 has none\)"
    with pytest.raises(polhode.BadInput, match=words):
        polhode.frequencies(path, of=["gamma3"], lines=1)
    assert set(polhode.frequencies(path).signals) == {"p"}


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("sign", [1, -1])
def test_so_many_lines_of_a_real_signal_are_so_many_frequencies(count, sign, tmp_path):
    """+f and -f counted as two: of five cosines three were left, and of one often none."""
    t = sign * STEP * np.arange(2000)
    file = sampled(tmp_path / "x.csv", {"t": t, "r": 7 + cosines(FIVE, t)})
    lines = polhode.frequencies(file, of=["r"], lines=count).lines["r"]
    result = sorted(line.frequency for line in lines)
    assert len(result) == count
    nearest = [min(FIVE, key=lambda rate: abs(rate - x)) for x in result]
    assert len({*nearest}) == count
    for line in lines:
        k = int(np.argmin(np.abs(np.array(FIVE) - line.frequency)))
        assert abs(line.frequency - FIVE[k]) <= line.error < 1e-9
        # the phase at the first sample, of the image above 0
        assert abs(line.amplitude - np.exp(1j * k) / 2) < 1e-6


def test_the_last_time_is_told_and_not_the_length(tmp_path):
    """It was the length."""
    t = 5 + STEP * np.arange(100)
    file = sampled(tmp_path / "x.csv", {"t": t, "r": np.cos(t)})
    run = polhode.integrate("euler/attitude", at=[5 + Fraction(k, 10) for k in range(100)])
    for source in (file, run):
        analysis = polhode.frequencies(source, of=["r"])
        assert analysis.end == pytest.approx(14.9, rel=1e-15)
        assert "to t = 14.9" in repr(analysis)


def test_one_line_of_a_pure_cosine_is_its_frequency(tmp_path):
    t = STEP * np.arange(1000)
    for rate in np.random.default_rng(5).uniform(0.3, 15, 8):
        file = sampled(tmp_path / "x.csv", {"t": t, "gamma3": np.cos(rate * t)})
        (line,) = polhode.frequencies(file, of=["gamma3"], lines=1).lines["gamma3"]
        assert abs(line.frequency - rate) <= line.error < 1e-9


def test_of_a_complex_signal_both_signs_are_lines_and_so_is_a_constant(tmp_path):
    t = STEP * np.arange(2000)
    columns = {"t": t, "p": 0.1 + 3 * np.cos(t), "q": np.sin(t)}
    lines = polhode.frequencies(sampled(tmp_path / "x.csv", columns), of=["p+iq"]).lines["p+iq"]
    result = [(line.frequency, abs(line.amplitude)) for line in lines[:3]]
    for (rate, size), expected in zip(result, [(1, 2), (-1, 1), (0, 0.1)], strict=True):
        assert rate == pytest.approx(expected[0], abs=1e-10)
        assert size == pytest.approx(expected[1], rel=1e-9)
    assert all(abs(line.amplitude) < 1e-12 for line in lines[3:])


@pytest.mark.parametrize("signal", ["p", "q", "r", "gamma1", "gamma2", "gamma3"])
@pytest.mark.parametrize("case", ["lagrange/nutation", "euler/attitude"])
def test_a_real_signal_of_a_top_has_a_line(case, signal):
    heavy = case == "lagrange/nutation"
    if "gamma" in signal and not heavy:
        return
    (lines,) = polhode.frequencies(case, of=[signal], end=150, lines=2).lines.values()
    assert len(lines) == (0 if heavy and signal == "r" else 2)  # its spin about its axis
    assert all(line.frequency > 0 for line in lines)


def test_the_verb_tells_a_line_of_each_signal(capsys):
    command = ["frequencies", "lagrange/nutation", "--of", "gamma3", "--end", "200"]
    assert main([*command, "--lines", "1", "--json"]) == 0
    output = capsys.readouterr()
    assert json.loads(output.out)["columns"]["combination"] == ["nutation"]
    assert "no line above rounding" not in output.err


@pytest.mark.slow
def test_slow_lines_beside_a_constant_claim_no_digits_that_they_lack(tmp_path):
    """Within a few 2 pi/T of 0 a line, its mirror image and the constant hide each other."""
    rng, factors = np.random.default_rng(3), []
    for least, most in [(0.05, 1), (1, 2), (2, 6), (0.3, 1), (6, 12)]:
        for _ in range(5):
            n = int(rng.integers(600, 1000))
            bins = np.cumsum(rng.uniform(least, most, int(rng.integers(1, 4))))
            rates = bins * 2 * np.pi / (STEP * (n - 1))
            sizes = rng.uniform(0.01, 1, len(rates)) * np.exp(2j * np.pi * rng.random(len(rates)))
            waves = np.exp(1j * np.outer(STEP * np.arange(n), rates)) @ sizes
            signal = {"t": STEP * np.arange(n), "r": rng.uniform(-10, 10) + waves.real}
            path = sampled(tmp_path / "x.csv", signal)
            for line in polhode.frequencies(path, of=["r"], lines=len(rates)).lines["r"]:
                off = float(np.min(np.abs(rates - line.frequency)))
                assert off <= line.error
                factors.append(line.error / max(off, 2**-50 * line.frequency))
    assert np.median(factors) < 100


@pytest.mark.parametrize("decimals", [3, 6, 9])
@pytest.mark.parametrize("rate", [60, 128, 59.94, 240])
def test_stamps_that_are_rounded_are_equally_spaced(rate, decimals, tmp_path):
    """60 Hz in 6 decimals was refused; 128 Hz has stamps halfway between two of them."""
    t = np.arange(1200) / rate
    expected = 2 * math.pi * rate / 17.3
    file = sampled(tmp_path / "x.csv", {"t": t, "r": np.cos(expected * t)}, decimals)
    analysis = polhode.frequencies(file, lines=1)
    (line,) = analysis.lines["r"]
    assert abs(analysis.step - 1 / rate) <= analysis.step_error + 2**-50 / rate
    # halves of two units, over 1200 steps: no spacing farther off fits
    assert analysis.step_error <= 10.0**-decimals / 600
    assert analysis.fact("step_error") == analysis.step_error
    assert abs(line.frequency - expected) <= line.error
    assert line.error >= expected * rate * analysis.step_error
    assert line.error < expected * rate * analysis.step_error + 1e-9 * expected


@pytest.mark.parametrize("off", [2, 40])
def test_a_stamp_that_is_off_by_more_than_rounding_is_refused(off, tmp_path):
    t = np.arange(200) / 60
    t[120] += off * 1e-6
    file = sampled(tmp_path / "x.csv", {"t": t, "r": np.cos(t)}, 6)
    with pytest.raises(polhode.BadInput, match="or their last printed decimal"):
        polhode.frequencies(file)


# -- levels ----------------------------------------------------------------------------------------

LEVEL = """schema = 1
[body]
moments = [2, 1.5, 1]
centre = [0.3, 0.2, 0.5]
weight = 1
[start]
gamma = ["4/5", "3/5", 0]
h = 2
f = "3/10"
"""


def test_a_level_that_the_scene_says_is_not_rounded():
    """omega is a root there: h and f were computed from it, and were "(rounded)"."""
    scene = scene_of(LEVEL, "top.toml")
    here = polhode.levels(scene).here
    for closed_orbit in (
        polhode.orbit(scene, digits=18),
        polhode.section(scene, starts="scene", crossings=2, accuracy=False),
        polhode.chaos_map(scene, grid=(2, 2), end=5),
    ):
        assert (
            (closed_orbit.fact("h"), closed_orbit.fact("f"))
            == (here.h, here.f)
            == (2, Fraction(3, 10))
        )


@pytest.mark.slow
def test_a_theorem_is_of_the_level_that_the_scene_says():
    theorem = polhode.prove_orbit(scene_of(LEVEL, "top.toml")).theorem
    assert "on the level h = 2, f = 3/10 exactly one" in theorem


@pytest.mark.parametrize("off", ["-1e-22", "1e-200"])
def test_a_centre_barely_off_an_axis_needs_no_exact_levels(off):
    """They were out of reach, and sections, maps and orbits, of doubles alone, were refused."""
    body = {"moments": [2, "1.5", 1], "weight": 1}
    start = {"omega": ["0.3", "0.2", 1], "gamma": ["4/5", 0, "3/5"]}
    near, on = (polhode.top(**body, centre=[x, 0, 1], **start) for x in (off, 0))
    for more in ({"starts": "scene"}, {"grid": (2, 2)}):
        options = {"crossings": 3, "accuracy": False} | more
        first, second = (polhode.section(top, **options) for top in (near, on))
        assert np.abs(first.states - second.states).max() < 1e-12
    assert polhode.chaos_map(near, grid=(2, 2), end=5).fact("h") == near.integrals.energy


@pytest.mark.parametrize("f", ["0", "1e-60", "1.6", "1e9"])
@pytest.mark.parametrize(
    "case", ["general/asymmetric-chaotic", "euler/prolate", "lagrange/nutation"]
)
def test_a_level_that_is_none_is_refused_by_the_least_energy_of_exact_levels(case, f):
    """In doubles, without isolating roots; beyond exact levels it was called by a bound."""
    area = Fraction(f)
    if f == "1e-60" or (case, f) == ("euler/prolate", "0"):
        least = {"general": -(0.38**0.5), "lagrange": -1.0, "euler": 0.0}[case.partition("/")[0]]
    else:
        least = polhode.levels(case).regions(area)[0][0]
    size = float(area) ** 2 + 1
    with pytest.raises(polhode.BadInput, match="the least energy at f") as caught:
        polhode.section(case, h=least - 1e-10 * size, f=area, crossings=2)
    text = float(str(caught.value).partition("above ")[2].partition(",")[0])
    assert text == pytest.approx(least, rel=1e-11, abs=1e-13)
    said = ""
    try:  # just above it there is a level, though the cells of a grid may miss it
        polhode.section(case, h=least + 1e-10 * size, f=area, crossings=1, accuracy=False)
    except polhode.BadInput as fault:
        said = str(fault)
    assert not said or "a finer grid, or another level" in said


# -- precession ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("moments", "omega", "axis", "moment"),
    [
        ([1, 2, 3], ["0.1", 0, 1], 3, "largest"),
        ([1, 2, 3], [1, "0.1", "0.1"], 1, "smallest"),
        ([2, 3, "1.5"], ["0.1", 1, 0], 2, "largest"),
        ([2, 2, 1], ["0.1", 0, 1], 3, "smallest"),
        ([3, 2, 2], [1, "0.1", 0], 1, "largest"),
    ],
)
def test_a_precession_says_of_which_axis(moments, omega, axis, moment):
    """And that axis turns about G at this rate, in space."""
    body = {"moments": moments, "omega": omega, "gamma": [0, 0, 1]}
    top = polhode.top(**body, outputs=["attitude"])
    exact = polhode.reference(top)
    words = f"of principal axis {axis} (of the {moment} moment) about the angular momentum"
    assert exact.rates_of == {"precession": words}
    run = polhode.integrate(top, at=[k / 8 for k in range(801)])
    turns = np.array(run.attitude, float)

    def in_space(turn, v):
        scalar, vector = turn[0], turn[1:]
        return v + 2 * np.cross(vector, np.cross(vector, v) + scalar * v)

    up = in_space(turns[0], np.array(moments, float) * [float(x) for x in omega])
    up = up / np.linalg.norm(up)
    first = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    second = np.cross(up, first)
    axes = [in_space(turn, np.eye(3)[axis - 1]) for turn in turns]
    angle = np.unwrap([math.atan2(second @ x, first @ x) for x in axes])
    rate = (angle[-1] - angle[0]) / 100
    assert rate == pytest.approx(float(exact.frequencies["precession"]), abs=0.03)


def test_show_and_frequencies_tell_it(capsys):
    assert main(["show", "euler/attitude"]) == 0
    assert "precession = of principal axis 3 (of the largest moment)" in capsys.readouterr().out
    assert main(["frequencies", "lagrange/nutation", "--end", "100", "--of", "gamma3"]) == 0
    output = capsys.readouterr().err
    assert (
        "precession of the axis of symmetry through the centre of mass about the vertical ="
        in output
    )


# -- bodies that doubles do not hold ---------------------------------------------------------------


@pytest.mark.parametrize(
    "question",
    [
        polhode.orbit,
        lambda scene: polhode.orbit_family(scene, by="h", to=3),
        lambda scene: polhode.conditioning(scene, [1]),
    ],
)
def test_a_body_with_a_number_beyond_doubles_is_refused_in_a_line(question):
    """A centre 1e-400 off an axis: it ended in a traceback of another error."""
    scene = polhode.top(
        moments=[1, "6/5", "7/10"],
        centre=["1/10**400", 0, 1],
        weight=1,
        omega=["0.3", "0.2", "1.5"],
        gamma=["0.6", 0, "0.8"],
    )
    with pytest.raises(polhode.BadInput, match=r"number = double: expected a type of wider range"):
        question(scene)
