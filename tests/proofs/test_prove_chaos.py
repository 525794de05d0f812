"""Proved chaos: what is claimed holds, what is false is refused, each condition is needed."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from flint import arb, ctx

import polhode
from polhode.certificates import chaos_certificate, verify
from polhode.cli import main
from polhode.proofs.chaos import homoclinic
from polhode.proofs.proved_orbit import as_arb
from shared import chaos_chains as chains
from shared import orbit_proofs as proofs


@pytest.mark.slow
def test_directions_keep_their_sign_whatever_linear_algebra_chooses(monkeypatch):
    made, (orbit, begun) = np.linalg.eig, chains.guess()
    point, period = np.array(chains.start_of(orbit)), float(orbit.period)
    found = []
    for sign in (1.0, -1.0):
        monkeypatch.setattr(np.linalg, "eig", lambda a, s=sign: (made(a)[0], s * made(a)[1]))
        found.append(homoclinic.saddle(begun.lanes, point, period))
    for name in ("unstable", "stable"):
        one, other = (getattr(x, name) for x in found)
        assert np.array_equal(one, other)
        assert np.max(one) == 1.0 == np.max(np.abs(one))


def test_the_example_is_proved_with_the_entropy_of_its_times():
    what = chains.example()
    found = what.proof
    assert len(found.margins) == 19
    assert min(x.stretch for x in found.margins) > 1.2
    assert max(x.height for x in found.margins) < 0.95
    assert min(x.cone for x in found.margins) > 0.1
    assert 4.26575 < found.short < 4.26577
    assert 77.69 < found.long < 77.71
    for entropy, proved in (("0.02807", True), ("0.02809", False)):
        claim = {"entropy": entropy, "short": "4.26577", "long": "77.71"}
        if proved:
            assert "statement" in chaos_certificate.stated(what.made, claim, found)
        else:
            with pytest.raises(verify.NotProved, match="the entropy is not shown"):
                chaos_certificate.stated(what.made, claim, found)


@pytest.mark.sample(1, first=1, slow=1)
@pytest.mark.parametrize("k", [0, 1, 9, 17])
def test_points_of_a_set_are_where_its_image_says(k):
    """At corners and between; the slope holds the differences of the section map."""
    what = chains.example()
    source = what.chain.sets[k]
    chart, target = (
        what.chain.charts[x.chart]
        for x in (source, what.chain.sets[(k + 1) % len(what.chain.sets)])
    )
    image = what.proof.images[k]
    assert chains.misses(image, source, chart, target, what.chain.times[k]) == 0
    rooms = [sum(float(v[i].abs_upper()) for v in image.columns[2:]) for i in range(6)]
    assert min(rooms) < 1e-6  # and the image is sharp


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("late", [0.0, 2e-3])
def test_points_of_a_set_that_leaves_the_level_and_is_late_are_where_its_image_says(late):
    assert chains.misses(*chains.tilted(late)) == 0


@pytest.mark.parametrize("k", [0, 1, 9])
def test_a_set_lies_in_its_disk(k):
    what = chains.example()
    source = what.chain.sets[k]
    chart = what.chain.charts[source.chart]
    with ctx.workprec(100):
        run, *_ = what.proof.home
        scale = what.made["scale"]
        numbers = verify._chart_numbers(what.made["charts"][source.chart], "")
        rectangle = verify._rectangle(what.made["sets"][k], scale, 99, "")
        level = verify.read_body(what.made["scene"], ("level",))[2]
        depth, _ = verify._disk(run, level, rectangle, verify._chart(numbers, scale, run))
        for xi, eta in chains.CORNERS:
            _, n = chains.point_of(source, chart, xi, eta)
            for a, b in zip(n, depth, strict=True):
                assert abs(a - float(b.mid())) <= 1.001 * float(b.rad()) + 1e-15


def known(orbit):
    with ctx.workprec(200):
        return [as_arb(x) for x in (*orbit.omega, *orbit.gamma)], as_arb(orbit.period)


def test_the_periodic_orbit_of_the_first_set_is_the_one_that_was_proved():
    what = chains.example()
    start, period = known(what.orbit)
    chaos_certificate.passes(what.proof, start, period)
    other, _ = known(proofs.proved(proofs.ELLIPTIC))
    width, height = what.chain.sets[0].width, what.chain.sets[0].height
    wide, tall = (what.chain.charts[0].wide[:, j].tolist() for j in (0, 1))
    lower = what.chain.charts[0].deep[:, 0].tolist()
    false = [(other, period, "through the first set|touch|miss|no bound")]
    for column, far in ((wide, 1.01 * width), (tall, -1.01 * height), (lower, 1.1e-4)):
        beside = [x + far * y for x, y in zip(start, column, strict=True)]
        false.append((beside, period, "through the first set|no bound"))
    for later in ("0.001", "-0.001"):
        false.append((start, period + arb(later), "a time of the short loop"))
    false.append((start, 2 * period, "a time of the short loop"))
    for at, time, why in false:
        with pytest.raises(verify.NotProved, match=why):
            chaos_certificate.passes(what.proof, at, time)


def attempt(**changes):
    """The example's chain, some of it another."""
    return chaos_certificate.proved(chaos_certificate.guesses(chain_with(**changes)))


def chain_with(**changes):
    what = chains.example().chain
    return what._replace(**{name: change(getattr(what, name)) for name, change in changes.items()})


def moved(k, by):
    """The charts with one centre moved along its first direction."""

    def change(charts):
        found = copy.copy(charts)
        found[k] = found[k]._replace(centre=found[k].centre + by * found[k].wide[:, 0])
        return found

    return change


def each(**changes):
    return lambda charts: [c._replace(**{k: f(c) for k, f in changes.items()}) for c in charts]


SIZE = 1e-6
#: What a chain is made of, wrong; and why it is refused.
FALSE = {
    "the first centre": ({"charts": moved(0, 3 * SIZE)}, "set 0"),
    "the second centre": ({"charts": moved(1, 3 * SIZE)}, "over set"),
    "a time": ({"times": lambda t: [t[0] + 0.1, *t[1:]]}, "set 0"),
    "too small a depth": ({"charts": each(eta=lambda c: 1e-13)}, "set 0"),
    "too large a depth": ({"charts": each(eta=lambda c: 0.3)}, "no graph"),
    "exchanged directions": ({"charts": each(wide=lambda c: c.wide[:, ::-1])}, "set 0 over set 0"),
    "first sets that meet": (
        {"sets": lambda s: [s[0], s[1]._replace(middle=0.5 * s[0].width), *s[2:]]},
        "may meet",
    ),
    "first sets in two charts": (
        {"sets": lambda s: [s[0], s[1]._replace(chart=1), *s[2:]]},
        "not of one section map",
    ),
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("what", FALSE)
def test_a_false_chain_is_refused(what):
    changes, why = FALSE[what]
    with pytest.raises(verify.NotProved, match=why):
        attempt(**changes)


def test_a_certificate_in_memory_is_the_one_that_is_saved(tmp_path):
    what = chains.example()
    claim = {"entropy": "0.028", "short": "4.26577", "long": "77.71"}
    made = chaos_certificate.stated(what.made, claim, what.proof)
    assert set(made) == set(json.loads(json.dumps(made)))
    with pytest.raises(verify.NotProved, match="the long loop may take longer"):
        chaos_certificate.stated(what.made, claim | {"long": "77.6"}, what.proof)


@pytest.mark.slow
def test_an_elliptic_orbit_and_integrable_tops_are_refused(capsys):
    orbit = polhode.orbit("general/asymmetric-regular")
    with pytest.raises(polhode.NotProved, match="elliptic"):
        polhode.prove_chaos("general/asymmetric-regular", orbit)
    assert main(["prove", "chaos", "lagrange/backward"]) == 3
    told = capsys.readouterr()
    assert told.out == ""
    assert "not proved: lagrange/backward" in told.err
