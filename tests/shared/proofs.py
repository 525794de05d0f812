"""The body, the level and three orbits that tests prove, and their proofs."""

import contextlib
import json
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from flint import arb, ctx

import polhode
from polhode import ProvedOrbit, ProvedStability
from polhode.certificates import verify
from polhode.certificates.certificate_file import by_checker
from polhode.dynamics.level_body import LevelBody
from polhode.numbers.number_types import Doubles, double_array
from polhode.proofs import chaos_certificate, homoclinic
from polhode.proofs.chaos_certificate import Chart, Guess, Rectangle
from polhode.proofs.homoclinic import Homoclinic

#: The body and the level of the examples; the orbits as a search in double found them.
MOMENTS = [Fraction(2), Fraction(3, 2), Fraction(1)]
TORQUE = [Fraction(3, 10), Fraction(1, 5), Fraction(1, 2)]
H, F = Fraction(261, 200), Fraction(31, 25)
BODY = polhode.top(
    moments=MOMENTS, centre=TORQUE, weight=1, omega=["3/10", "1/5", 1], gamma=["3/5", 0, "4/5"]
)
ELLIPTIC = (
    *(0.24648456378902078, 0.3484822174895774, -1.880218379593652),
    *(-0.4532503649457642, -0.26342557792225096, -0.8515697690576267),
    3.221902062960887,
)
HYPERBOLIC = (
    *(0.39248732502901934, -1.4931034249442232, -0.3812431760503589),
    *(-0.304878314545795, -0.5252810140625632, -0.7944363219195862),
    4.265751022846151,
)


def body_of(moments: Sequence[float], torque: Sequence[float] = (0, 0, 0)) -> verify.Body:
    """The checker's body of principal moments, at the precision that is set."""
    rows = [[arb(x if i == j else 0) for j in range(3)] for i, x in enumerate(moments)]
    return verify.Body(rows, [arb(x) for x in torque])


def near(point: Sequence[float], rate: int = 1) -> polhode.Scene:
    """A scene that ends after about one period; of the same motion, so many times as fast."""
    p, q, r, *gamma, period = map(Fraction, point)
    return polhode.top(
        moments=MOMENTS,
        centre=TORQUE,
        weight=rate**2,
        omega=[rate * x for x in (p, q, r)],
        gamma=gamma,
        normalise=True,
        end=period / rate,
    )


@cache
def proved(point: tuple[float, ...], digits: int = 30) -> ProvedOrbit:
    """The proof of an orbit of the level."""
    scene = near(point)
    return polhode.prove_orbit(scene, scene, digits=digits, h=H, f=F)


# -- the elliptic orbit whose stability is proved

NAME = "general/asymmetric-regular"
START = (
    *(0.12824297888944370, 0.16218517053029624, -3.3992382255227273),
    *(-0.42077601050440881, -0.27781263962028001, -0.86357841928293117),
)
PERIOD = 1.81463648378177924


def stable_start(start: tuple[float, ...] = START, period: float = PERIOD) -> polhode.Scene:
    """A scene that ends after about one period."""
    scene = polhode.load(NAME)
    p, q, r, *gamma = map(Fraction, start)
    body: dict[str, Any] = {"moments": scene.body.moments, "centre": scene.body.centre}
    return polhode.top(
        **body,
        weight=scene.body.weight,
        omega=[p, q, r],
        gamma=gamma,
        normalise=True,
        end=Fraction(period),
    )


@cache
def orbit() -> ProvedOrbit:
    """The proved orbit."""
    return polhode.prove_orbit(NAME, stable_start())


@cache
def stability() -> ProvedStability:
    """Its proved stability."""
    return polhode.prove_stability(orbit())


def certificate() -> dict[str, Any]:
    """The certificate, of which everyone may change a copy."""
    document: dict[str, Any] = json.loads(stability().certificate)
    return document


# -- a chain of sets along one homoclinic orbit of the example

#: As the search finds it.
NEAR = Homoclinic(0.000179164892, -0.000465148702, 23.4075408124, 24.4302533376, 0.17)


class Example(NamedTuple):
    """A proof and what it began with, in principal axes, which are the scene's."""

    orbit: ProvedOrbit
    guess: Guess
    guesses: dict[str, Any]
    proof: verify.Horseshoe


@cache
def guess() -> tuple[ProvedOrbit, Guess]:
    """The chain at h = 261/200, f = 31/25, time in the scene's unit."""
    orbit = proved(HYPERBOLIC)
    surface = LevelBody(orbit.near, H, F)
    assert surface.unit == 1
    saddle = homoclinic.saddle(surface, np.array(start_of(orbit)), float(orbit.period))
    assert saddle is not None
    moved, size = homoclinic.towards(saddle, NEAR, 1e-6)
    connection = homoclinic.connection_near(surface, saddle, moved)
    assert connection is not None
    return orbit, chaos_certificate.guess_along(surface, saddle, connection, size)


@cache
def example() -> Example:
    """The proof of it."""
    orbit, first_guess = guess()
    guesses = chaos_certificate.guesses(first_guess)
    return Example(orbit, first_guess, guesses, by_checker(verify.horseshoe, guesses))


def start_of(orbit: ProvedOrbit) -> Sequence[float]:
    """A point of a proved orbit."""
    return [float(x) for x in (*orbit.omega, *orbit.gamma)]


# -- points of sets, in double

CORNERS = [(a, b) for a in (-1.0, 0.3, 1.0) for b in (-1.0, -0.4, 1.0)]
INERTIA, PULL = (np.array([float(x) for x in v]) for v in (MOMENTS, TORQUE))
LEVEL = np.array([2 * float(H), float(F), 1.0])


def integrals(x: Doubles) -> tuple[Doubles, Doubles]:
    """The three integrals, and their gradients."""
    w, g = x[:3], x[3:]
    values = [(INERTIA * w * w).sum() + 2 * PULL @ g, (INERTIA * w * g).sum(), g @ g]
    rows = [[*(2 * INERTIA * w), *(2 * PULL)], [*(INERTIA * g), *(INERTIA * w)], [0, 0, 0, *2 * g]]
    return np.array(values), np.array(rows)


def point_of(source: Rectangle, chart: Chart, xi: float, eta: float) -> tuple[Doubles, Doubles]:
    """A point of a set in double, its four equations solved by Newton's method; and n."""
    flat = chart.wide @ [source.middle + xi * source.width, eta * source.height]
    n = np.zeros(4)
    for _ in range(5):
        off = flat + chart.deep @ n
        values, rows = integrals(chart.centre + off)
        miss = [*(values - LEVEL), chart.plane @ off]
        n = n - np.linalg.solve(np.vstack([rows, chart.plane]) @ chart.deep, miss)
    return chart.centre + flat + chart.deep @ n, n


def crossed(chart: Chart, x: Doubles, time: float) -> tuple[Doubles, float]:
    """Where a motion meets the plane of a chart, in its coordinates, in double; and when."""
    surface = guess()[1].surface
    for _ in range(5):
        end = double_array(surface.plain_flow.after(x, time).state)
        time -= float(chart.plane @ (end - chart.centre) / (chart.plane @ surface.rates(end)))
    frame = np.hstack([chart.wide, chart.deep])
    return np.linalg.solve(frame, end - chart.centre), time


def tilted(
    late: float, by: float = 0.1, above: float = 0.0
) -> tuple[verify.Image, Rectangle, Chart, Chart, float]:
    """A set whose directions leave the level, its image at a time that is late; as of misses.

    ``above``: the level, along the gradient of the energy, lies the chart's centre.
    """
    chain = example().guess
    chart = chain.charts[0]
    centre = chart.centre + above * chart.deep[:, 0]
    chart = chart._replace(centre=centre, wide=chart.wide + by * chart.deep[:, :2])
    times = [chain.times[0] + late, *chain.times[1:]]
    later = chain._replace(charts=[chart, *chain.charts[1:]], times=times)
    image = first_image(chaos_certificate.guesses(later))
    return image, chain.sets[0], chart, chart, times[0]


def stepped(time: float) -> tuple[verify.Image, Rectangle, Chart, Chart, float]:
    """N0 one step further, its directions carried on: as of misses."""
    chain, surface = example().guess, guess()[1].surface
    chart, source = chain.charts[0], chain.sets[0]
    place, slope = homoclinic.flow_with_derivative(surface, chart.centre, time)
    target = chaos_certificate.chart_at(surface, place, *(slope @ chart.wide).T)
    after = chain._replace(charts=[chart, target], sets=[source], times=[time])
    guesses: Any = chaos_certificate.guesses(after)
    with ctx.workprec(guesses["bits"] + 2 * verify.COARSE):
        transit = verify._transit(guesses["transits"][0], guesses["bits"], "")
        scene = verify.read_body(guesses["scene"], ("level",))
        run = verify.Run(transit, *verify.balls_of(scene)[:2])
        assert len(run.grid) == 2
        charts = [verify._chart_numbers(x, "") for x in guesses["charts"]]
        places = [verify._chart(x, guesses["scale"], run) for x in charts]
        rectangle = verify._rectangle(guesses["sets"][0], guesses["scale"], 2, "")
        image = verify._image(run, scene[2], rectangle, places[0], places[1], None)
    return image, source, chart, target, time


class Enough(Exception):
    """The first image is there."""


def first_image(guesses: dict[str, Any]) -> verify.Image:
    """The image of N0, whatever it covers."""
    images: list[verify.Image] = []

    def covers(image: verify.Image, *_: object) -> verify.Margins:
        images.append(image)
        raise Enough

    with pytest.MonkeyPatch.context() as patch, contextlib.suppress(Enough):
        patch.setattr(verify, "covers", covers)
        by_checker(verify.horseshoe, guesses)
    return images[0]


def misses(image: verify.Image, source: Rectangle, chart: Chart, target: Chart, time: float) -> int:
    """How many components of points of a set, times and slopes are outside of its image's balls."""
    places, count = {}, 0
    unit = 2.0 ** example().proof.home[0].shift  # of the run's time
    for xi, eta in CORNERS:
        x, _ = point_of(source, chart, xi, eta)
        where, when = crossed(target, x, time)
        places[xi, eta] = where
        count += not float(image.least) < when * unit < float(image.most)
        for i in range(6):
            middle = image.shift[i] + image.columns[0][i] * xi + image.columns[1][i] * eta
            room = sum(float(v[i].abs_upper()) for v in image.columns[2:]) + float(middle.rad())
            count += not abs(where[i] - float(middle.mid())) <= room + 2e-14  # the doubles' error
    begin = places[-1.0, -1.0]
    for j, (corner, size) in enumerate([((1.0, -1.0), source.width), ((-1.0, 1.0), source.height)]):
        for i in range(2):
            slope = (places[corner][i] - begin[i]) / (2 * size)
            off = abs(slope - float(image.slope[i, j].mid()))
            count += not off <= float(image.slope[i, j].rad()) + 1e-13 / size
    return count
