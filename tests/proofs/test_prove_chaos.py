"""Proved chaos: what is claimed holds, what is false is refused, each condition is needed."""

from __future__ import annotations

import copy
import itertools

import numpy as np
import pytest
from flint import arb, ctx

import polhode
from polhode.certificates import verify
from polhode.certificates.certificate_file import by_checker
from polhode.cli import main
from polhode.proofs import homoclinic
from polhode.proofs.chaos_certificate import Rectangle
from polhode.proofs.proved_orbit import as_arb
from shared import proofs as chains


@pytest.mark.slow
def test_directions_keep_their_sign_whatever_linear_algebra_chooses(monkeypatch):
    eig, (orbit, guess) = np.linalg.eig, chains.guess()
    point, period = np.array(chains.start_of(orbit)), float(orbit.period)
    saddles = []
    for sign in (1.0, -1.0):
        monkeypatch.setattr(np.linalg, "eig", lambda a, s=sign: (eig(a)[0], s * eig(a)[1]))
        saddles.append(homoclinic.saddle(guess.surface, point, period))
    for name in ("unstable", "stable"):
        first, second = (getattr(x, name) for x in saddles)
        assert np.array_equal(first, second)
        assert np.max(first) == 1.0 == np.max(np.abs(first))


@pytest.mark.slow
def test_the_example_is_proved_with_the_entropy_of_its_times():
    example = chains.example()
    proof = example.proof
    assert len(proof.margins) == 19
    assert min(x.stretch for x in proof.margins) > 1.2
    assert max(x.height for x in proof.margins) < 0.95
    assert min(x.cone for x in proof.margins) > 0.1
    assert 4.26575 < proof.short < 4.26577
    assert 77.69 < proof.long < 77.71
    with ctx.workprec(100):
        times = [float(x.most * proof.home[0].rates[0]) for x in proof.images]
    assert times[0] <= float(proof.short)
    assert sum(times) <= float(proof.long) * (1 + 1e-14)
    claim = {"entropy": "0.02807", "short": "4.26577", "long": "77.71"}
    by_checker(verify.check_chaos, verify.read_chaos(claim), proof)
    for change, why in (
        ({"entropy": "0.02809"}, "not shown to be as large"),
        ({"short": "4.2657"}, "the short loop may take longer"),
        ({"long": "77.6"}, "the long loop may take longer"),
    ):
        with pytest.raises(verify.NotProved, match=why):
            by_checker(verify.check_chaos, verify.read_chaos(claim | change), proof)


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 9])
def test_points_of_a_set_are_where_its_image_says(k):
    """At corners and between; the slope holds the differences of the section map."""
    chain, images = chains.example().guess, chains.example().proof.images
    source, after = chain.sets[k], chain.sets[(k + 1) % len(chain.sets)]
    chart, target = (chain.charts[x.chart] for x in (source, after))
    image = images[k]
    assert chains.misses(image, source, chart, target, chain.times[k]) == 0
    rooms = [sum(float(v[i].abs_upper()) for v in image.columns[2:]) for i in range(6)]
    assert min(rooms) < 1e-6  # and the image is sharp


@pytest.mark.slow
@pytest.mark.parametrize(
    ("late", "by", "above"), [(0.0, 0.1, 0.0), (2e-3, 0.1, 0.0), (0.0, 0.0, 1e-6)]
)
def test_points_of_a_set_off_the_level_and_late_are_where_its_image_says(late, by, above):
    assert chains.misses(*chains.tilted(late, by, above)) == 0


def test_points_of_a_set_are_where_a_step_of_a_poor_transition_says(monkeypatch):
    """V is off by a hundredth: what the step leaves out holds that."""
    chains.example()  # proved by the honest one
    honest = verify.next_of_v

    def bent(total, k):
        return (honest(total, k) * arb("1.01" if k == 0 else 1)).mid()

    monkeypatch.setattr(verify, "next_of_v", bent)
    assert chains.misses(*chains.stepped(0.125)) == 0


def test_slopes_of_an_image_are_those_of_every_time_of_its_crossing(monkeypatch):
    """Where D may change by its own size in that time, they are known no better."""
    assert float(chains.stepped(0.125)[0].slope[0, 0].rad()) < 1e-3
    monkeypatch.setattr(verify, "drift", lambda *_: arb(1))
    assert float(chains.stepped(0.125)[0].slope[0, 0].rad()) > 0.1


def disk(source):
    """All n of a set, and n', in doubles: middles and radii."""
    guesses = chains.example().guesses
    with ctx.workprec(100):
        run, *_ = chains.example().proof.home
        numbers = verify._chart_numbers(guesses["charts"][source.chart], "")
        rectangle = verify.Rectangle(source.chart, *(arb(x) for x in source[1:]))
        level = verify.read_body(guesses["scene"], ("level",))[2]
        chart = verify._chart(numbers, guesses["scale"], run)
        depth, slope = verify._disk(run, level, rectangle, chart)
        rows = [depth, *zip(*slope.table(), strict=True)]
        return np.array([[(float(x.mid()), float(x.rad())) for x in row] for row in rows])


@pytest.mark.parametrize("k", [0, 1, 9, "far"])
def test_a_set_lies_in_its_disk(k):
    """One far from its chart's centre as well: the way there counts by half of its slope."""
    chain = chains.example().guess
    source = Rectangle(0, 1e-3, 1e-5, 1e-5) if k == "far" else chain.sets[k]
    chart = chain.charts[source.chart]
    (middle, radius), *_ = (rows.T for rows in disk(source))
    for corner in chains.CORNERS:
        _, n = chains.point_of(source, chart, *corner)
        assert np.all(np.abs(n - middle) <= 1.001 * radius + 1e-15)


def test_slopes_of_a_large_set_lie_in_those_of_its_disk():
    """They differ from corner to corner by as much as its size."""
    size, near = 1e-3, 0.05
    source, chart = Rectangle(0, 0.0, size, size), chains.example().guess.charts[0]
    _, *slopes = (rows.T for rows in disk(source))
    for corner in itertools.product((-1.0, 1.0), repeat=2):
        _, n = chains.point_of(source, chart, *corner)
        for j, (middle, radius) in enumerate(slopes):
            beside = [x * (1 - near * (i == j)) for i, x in enumerate(corner)]
            _, n_beside = chains.point_of(source, chart, *beside)
            slope = (n - n_beside) / (near * size * corner[j])
            assert np.all(np.abs(slope - middle) <= radius + 1e-9)
            assert np.max(radius) < 100 * size


def test_each_set_covers_the_next_within_the_depth_of_its_chart(monkeypatch):
    proof, pairs = chains.example().proof, []
    guesses = copy.deepcopy(chains.example().guesses)
    scale = guesses["scale"]
    depths = [2**scale // 10**4 + k for k in range(len(guesses["charts"]))]
    for chart, depth in zip(guesses["charts"], depths, strict=True):
        chart["eta"] = [[depth]]
    images = iter(proof.images)
    monkeypatch.setattr(verify, "_image", lambda *_: next(images))

    def covers(image, source, target, eta, where):
        pairs.append((source, target, eta))
        return proof.margins[0]

    monkeypatch.setattr(verify, "covers", covers)
    by_checker(verify.horseshoe, guesses)
    with ctx.workprec(200):
        sets = [verify._rectangle(x, scale, len(depths), "") for x in guesses["sets"]]
        count = len(sets)
        expected = [(sets[0], sets[0]), *((sets[k], sets[(k + 1) % count]) for k in range(count))]
        assert [pair[:2] for pair in pairs] == expected
        for _, target, eta in pairs:
            assert eta == verify.dyadic(depths[target.chart], -scale)


def balls_of(orbit):
    with ctx.workprec(200):
        return [as_arb(x) for x in (*orbit.omega, *orbit.gamma)], as_arb(orbit.period)


def test_the_periodic_orbit_of_the_first_set_is_the_one_that_was_proved():
    example = chains.example()
    start, period = balls_of(example.orbit)
    by_checker(verify.is_orbit_of, example.proof, start, period)
    elsewhere, _ = balls_of(chains.proved(chains.ELLIPTIC))
    width, height = example.guess.sets[0].width, example.guess.sets[0].height
    wide, tall = (example.guess.charts[0].wide[:, j].tolist() for j in (0, 1))
    lower = example.guess.charts[0].deep[:, 0].tolist()
    false = [(elsewhere, period, "through the first set|touch|miss|no bound")]
    for column, far in ((wide, 1.01 * width), (tall, -1.01 * height), (lower, 1.1e-4)):
        beside = [x + far * y for x, y in zip(start, column, strict=True)]
        false.append((beside, period, "through the first set|no bound"))
    # inside, but beside the plane, and outside where the motion meets that
    along = example.guess.charts[0].deep[:, 3]
    beside = 0.9999 * width * np.array(wide) + 9e-5 * along
    moved = [x + y for x, y in zip(start, beside.tolist(), strict=True)]
    false.append((moved, period, "through the first set|no bound"))
    for later in ("0.001", "-0.001"):
        false.append((start, period + arb(later), "a time of the short loop"))
    false.append((start, 2 * period, "a time of the short loop"))
    for at, time, why in false:
        with pytest.raises(verify.NotProved, match=why):
            by_checker(verify.is_orbit_of, example.proof, at, time)


def test_an_elliptic_orbit_is_refused(tmp_path, capsys):
    """An integrable top, too: the example of ``prove_chaos`` shows it."""
    path = tmp_path / "elliptic.toml"
    path.write_text(polhode.as_toml(chains.stable_start()))
    assert main(["prove", "chaos", chains.NAME, "--orbit", str(path)]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert f"not proved: {chains.NAME}: no transversal homoclinic orbit was found" in err
    assert "the periodic orbit is elliptic" in err


@pytest.mark.slow
def test_no_other_orbit_is_looked_at_when_all_tries_are_used_up(monkeypatch):
    """Each was proved once more, and its manifolds were announced."""

    def refuse(*_):
        raise verify.NotProved("refused")

    monkeypatch.setattr(verify, "horseshoe", refuse)
    messages = []
    with pytest.raises(polhode.NotProved, match="1 chains of sets along 1 homoclinic"):
        polhode.prove_chaos("general/asymmetric-chaotic", tries=1, progress=messages.append)
    assert sum(text.startswith("manifolds") for text in messages) == 1
