"""What kind a motion is, by the growth of its tangents: the one definition.

*regular*: nearby motions separate no faster than a power of t (quasi-periodic motion, on a torus).
*unstable*: they separate exponentially, but the motion is known: a closed form, a fixed point, a
body that is integrable for every start.  It is unstable periodic, or asymptotic to such a motion,
as on a separatrix.
*chaotic*: they separate exponentially, and nothing of that kind is known.
*undecided*: the time is too short.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polhode.closed_forms.rotation_stability import jacobian, spectrum
from polhode.common.arguments import each, steps
from polhode.common.errors import BadInput
from polhode.equations.readout import at_rest
from polhode.judging.reference import reference
from polhode.motion.frame import Frame
from polhode.numbers.conversion import TIME, reader, to_double
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.number_types import AnyNumber, Doubles
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.body import EULER, KOVALEVSKAYA, LAGRANGE, SPHERE, Body, kind_of_body
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor.system import System, principal_system
from polhode.taylor.variations import Variations, pendulum, six

REGULAR, UNSTABLE, CHAOTIC, UNDECIDED = "regular", "unstable", "chaotic", "undecided"
#: Units of time, about a radian, before which no motion is called regular by its growth.
SHORTEST = 1000.0
#: Of ln |tangent| in the second half of the time: below the first regular, above the second not.
REGULAR_GROWTH, UNSTABLE_GROWTH = 2.0, 6.0


def of_growing(proven: bool) -> str:
    """The kind of a motion from which nearby motions separate exponentially."""
    return UNSTABLE if proven else CHAOTIC


def is_integrable(body: Body) -> bool:
    """Whether no motion of a body is chaotic, whatever its start."""
    return kind_of_body(body) in (EULER, LAGRANGE, SPHERE, KOVALEVSKAYA)


def shown(kind: str) -> str:
    """The kind in words."""
    return "unstable (periodic or asymptotic)" if kind == UNSTABLE else kind


# --- known stability ------------------------------------------------------------------------------
#
# Whether nearby motions leave a known motion exponentially, decided without a long run.
#
# What stands still, a state or the angular velocity of a free body, about which gamma turns: by
# the spectrum of its linear equations, exactly. The squares of the eigenvalues are 0 and the roots
# of x^2 + b x + d, real and not above 0 if and only if none has a real part.
#
# A periodic closed form: by its residue (6 - tr M)/4, M the change of the state over a period,
# whose multipliers are 1, 1, 1, 1, mu, 1/mu: hyperbolic outside 0 to 1. An integrable top on one
# of its tori, which a closed form tells by frequencies: nearby motions are on nearby tori. Any
# other closed form tends to a motion that it never is (a separatrix), or is not known well
# enough.


_TORI = {"polhode", "nutation", "s1"}  # rates that an integrable top has on its tori alone
_ANY_TORI = {"u", "turning"}  # rates of tori of other tops
_PARABOLIC = 1e-5  # of |M|: residues so near to 0 or 1 are not told from them


class Known(NamedTuple):
    """What is known of a motion's neighbours.

    ``rate``: of their exponential growth per unit of the run's time, 0 where there is none, None
    where it is not known.  ``words``: by what.  ``tends``: to another motion.
    """

    rate: float | None
    words: str
    tends: bool = False


def known_stability(scene: Scene, plain: System, most: int) -> Known:
    """What is known of the neighbours of a scene's motion, in at most so many steps of a period.

    ``plain``: the system in principal axes.
    """
    rest = at_rest(scene)
    if rest.state or (rest.omega and scene.body.torque_free):
        return Known(_growth_at_rest(Frame.of(scene).inside(scene)), "its eigenvalues")
    motion = reference(scene)
    if not motion.is_closed_form:
        return Known(None, "")
    rates = motion.frequencies.keys()
    if (is_integrable(scene.body) and rates & _TORI) or "u" in rates:
        return Known(0.0, "the torus that it lies on")
    if motion.period is not None:
        rate = _growth_of_period(plain, float(motion.period) / float(Frame.of(scene).unit), most)
        return Known(rate, "the residue of its period")
    return Known(None, "", not rates & _ANY_TORI and "quasi-periodic" not in motion.regime)


def growth_about(body: Body, state: Doubles) -> float:
    """The largest growth rate of the linear equations at a state of principal axes, in double."""
    moments, torque = ([to_double(x) for x in v] for v in (body.moments, body.torque))
    matrix = jacobian(moments, torque, state[:3].tolist(), state[3:].tolist())
    return float(np.linalg.eigvals(np.array(matrix)).real.max())


def _growth_at_rest(inside: Scene) -> float:
    """The largest real part of an eigenvalue at a start that stands still, in principal axes."""
    body, gamma = inside.body, inside.gamma or (ZERO, ZERO, ZERO)
    b, d = spectrum(body.moments, body.torque, inside.omega, gamma)
    gap = b * b - 4 * d
    if min(sign(b), sign(d), sign(gap)) >= 0:
        return 0.0
    root = cmath.sqrt(to_double(gap))
    squares = [(side * root - to_double(b)) / 2 for side in (1, -1)]
    return max(abs(cmath.sqrt(x).real) for x in squares) or math.ulp(0.0)


def _growth_of_period(plain: System, period: float, most: int) -> float | None:
    flow = Variations(plain.coefficients, np.array([*map(to_double, plain.start)]), np.eye(6))
    reached = flow.to(period, most)
    change = flow.tangents * 2.0**flow.exponent
    flow.release()
    residue = (6 - float(np.trace(change))) / 4
    away = max(-residue, residue - 1)
    sure = _PARABOLIC * float(np.linalg.norm(change))
    if not reached or abs(away) <= sure or min(abs(residue), abs(1 - residue)) <= sure:
        return None
    half = abs(1 - 2 * residue)
    return math.acosh(half) / abs(period) if away > 0 else 0.0


# --- lyapunov -------------------------------------------------------------------------------------
#
# Regular or chaotic: the largest Lyapunov exponent, from one tangent that is rescaled as it
# grows.
#
# Between the middle and the end of a regular motion a tangent grows like a power of time, by 2 to
# 4; on a chaotic one it grows exponentially. So it does on an unstable periodic or asymptotic
# one: no growth rate tells it from chaos, a closed form or a fixed point does. An exponential
# exp(lambda t) and a power of t are told apart once lambda T/2 passes 6, the power's growth being 3
# at most: a short T decides nothing, unless the motion is known. The motion is integrated in
# double: beyond the time at which its digits are lost it is a neighbour's, which has the same
# exponent where the motion is chaotic.


MAX_STEPS = 1_000_000  # of 3 µs
DEFAULT_LENGTH = 2000  # in the motion's slowest unit of time
BLOCKS, LOOKS = 32, 8  # blocks over the whole time, looks at the tangent in each
NEIGHBOURS, APART = 7, 1e-6  # of a chaotic motion: their number, their relative distance
MOVED = tuple(1 + APART * k for k in range(1, NEIGHBOURS + 1))  # times the start: neighbours
CLOSE = 8.0  # units of time at most between two looks at all tangents together
TANGENT = 0.6, -0.5, 0.4, 0.3, 0.2, -0.3  # along no axis
_POWER = "nearby motions separate no faster than a power of t"
DOUBLES_TRUE = 12 * math.log(10)  # ln of the growth up to which a double follows the motion


@dataclass(frozen=True, repr=False)
class Lyapunov(Result):
    """The largest exponent per unit of time, and the verdict on the motion up to ``end``.

    ``exponent`` is the mean growth of ln |tangent| over the second half of the time, per unit of
    the scene's time.  ``uncertainty``: for a chaotic motion the standard deviation of the exponents
    of this motion and seven nearby ones; for any other the standard error over blocks of time, plus
    2/``end``, the exponent that a power law may show.  ``growth``: of ln |tangent| over that half.
    ``verdict``: "regular" (nearby motions separate no faster than a power of t), "unstable"
    (exponentially, but the motion is known from a closed form or is a fixed point), "chaotic"
    (exponentially, and nothing of that kind is known) or "undecided" (the time is too short).
    ``spectrum``: all exponents from the largest down, where they were asked for: of six those along
    the motion and across h, f and |gamma|^2 are 0, which they show to about 2/``end``.

    >>> import polhode
    >>> polhode.lyapunov("euler/largest-axis", 1000).verdict
    'regular'
    """

    scene: Scene
    exponent: float
    uncertainty: float
    growth: float
    end: float
    verdict: str
    reason: str
    spectrum: tuple[float, ...] | None = None

    def table(self) -> Table:
        """One row: the verdict, and what it rests on."""
        time = unit_of(self.scene, "t")
        return Table(
            [
                Column("motion", [1]),
                Column("verdict", [self.verdict]),
                Column("exponent", [self.exponent], "", f"1/{time}", digits=4),
                Column("uncertainty", [self.uncertainty], "", f"1/{time}", digits=2),
                Column("growth", [self.growth], "of the logarithm, in the second half", digits=4),
                Column("end", [self.end], "how far it was followed", time),
            ]
        )

    def facts(self) -> list[Fact]:
        """The verdict, and why."""
        row = self.table().columns[1:]
        return [
            *scene_facts(self.scene),
            *(Fact(x.name, x.values[0], x.meaning, x.unit) for x in row),
            Fact("reason", self.reason),
            Fact("spectrum", self.spectrum and list(self.spectrum), "all exponents"),
            provenance_fact(self.scene.provenance()),
        ]

    def __repr__(self) -> str:
        return f"<Lyapunov of {self.scene.name}: {self}>"

    def __str__(self) -> str:
        return (
            f"{shown(self.verdict)}: exponent {self.exponent:.3g} ± "
            f"{self.uncertainty:.1g} (one standard deviation) up to t = {self.end:g}; {self.reason}"
        )


def lyapunov(
    scene: Scene | str | Path,
    end: AnyNumber | None = None,
    max_steps: int = MAX_STEPS,
    spectrum: bool = False,
) -> Lyapunov:
    """Estimate the largest Lyapunov exponent of a scene's motion, and classify the motion.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    end : number, optional
        The last time, in the scene's unit; by default the scene's own end, or 2000 units of the
        slower of its spin and its pendulum's swing if that is longer.
    max_steps : int
        A limit on the steps of the variational equations.
    spectrum : bool
        Whether to compute all exponents, by tangents that are made orthogonal again and again
        (G. Benettin et al., Meccanica 15 (1980) 9).

    Returns
    -------
    Lyapunov
        The exponent per unit of time, its standard deviation, and the verdict: regular, unstable,
        chaotic, or undecided if the time is too short.

    Raises
    ------
    BadInput
        An end at 0, or one beyond the range of doubles.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.lyapunov("general/asymmetric-chaotic", 2000)
    >>> found.verdict, 0.06 < found.exponent < 0.14
    ('chaotic', True)
    >>> found = polhode.lyapunov("general/asymmetric-chaotic", 2000, spectrum=True)
    >>> [round(abs(x), 1) for x in found.spectrum]
    [0.1, 0.0, 0.0, 0.0, 0.0, 0.1]
    """
    scene = library.load(scene, takes=REQUESTS)
    frame = Frame.of(scene)
    unit = float(frame.unit)
    slow = max(1.0, 1 / pendulum(frame.inside(scene)))  # a radian of the spin takes 1
    last = DEFAULT_LENGTH * slow
    max_steps = steps(scene.name, max_steps)
    if end is not None:
        (until,) = each(scene.name, "end", (end,), reader(scene.units, TIME), "a time")
        last = to_double(until) / unit
        if last == 0 or math.isinf(last):
            raise BadInput(scene.name, "end", end, "a time other than 0, in a double's range")
    elif abs(to_double(scene.end) / unit) > last:
        last = to_double(scene.end) / unit
    elif sign(scene.end) < 0:
        last = -last
    plain = principal_system(scene)
    start = six(plain.start)
    tangent = np.array(TANGENT)[:, None]
    if len(plain.start) == 3:
        tangent[3:] = 0
    still, closed = at_rest(scene).state, reference(scene).is_closed_form
    state = start

    def followed(start: Doubles, last: float) -> Iterator[float]:
        """The tangent's size at each look."""
        nonlocal state
        flow = Variations(plain.coefficients, start, tangent)
        yield _size(flow)
        for k in range(1, BLOCKS * LOOKS + 1):
            if not flow.to(last * k / (BLOCKS * LOOKS), max_steps - flow.steps):
                break
            if still:
                flow.state = start
            flow.rescale()
            state = flow.state.copy()
            yield _size(flow)
        flow.release()

    sizes: list[float] = []
    for size in followed(start, last):
        sizes.append(size)
        looks = len(sizes) - 1
        if closed and not still and looks < BLOCKS * LOOKS and size - sizes[0] > DOUBLES_TRUE:
            # as far as it is this motion
            return lyapunov(scene, last * looks / (BLOCKS * LOOKS) * unit, max_steps, spectrum)
    reached = abs(last) * (len(sizes) - 1) / (BLOCKS * LOOKS)
    exponent, error, growth = fitted(sizes, reached)
    stability, length = known_stability(scene, plain, max_steps), reached / slow
    about = "a fixed point; " if still else "a closed form is known; " if closed else ""
    verdict, reason = _judged(stability, about, growth, exponent, error, length, unit)
    if verdict == UNDECIDED:
        later = _deciding(stability, frame.inside(scene).body, state, reached, slow) * unit
        reason = f"{about}an end of {later:.2g} may decide"
    if verdict == CHAOTIC:
        moved = (start * by for by in MOVED)
        ends = [fitted([*followed(x, math.copysign(reached, last))], reached)[0] for x in moved]
        error = scatter([exponent, *ends])
    last = math.copysign(reached, last)
    every = None
    if spectrum and reached:
        flow = Variations(plain.coefficients, start, np.eye(6)[:, : len(plain.start)])
        rates = _all_exponents(flow, last, start if still else None, max_steps)
        every = tuple(float(x) / unit for x in rates)
        flow.release()
    exponents = last * unit
    return Lyapunov(scene, exponent / unit, error / unit, growth, exponents, verdict, reason, every)


def _all_exponents(flow: Variations, last: float, still: Doubles | None, most: int) -> Doubles:
    """The mean growth of tangents kept orthogonal, over the second half of the time, descending.

    ``still``: the state to be put back to, of a fixed point.  All nan where the end is not reached.
    """
    looks = 2 * math.ceil(max(BLOCKS * LOOKS, abs(last) / CLOSE) / 2)
    grown = np.zeros(flow.tangents.shape[1])
    half = grown
    for k in range(1, looks + 1):
        if not flow.to(last * k / looks, most - flow.steps):
            return grown * math.nan
        if still is not None:
            flow.state = still
        across, sizes = np.linalg.qr(flow.tangents)
        flow.tangents[:] = across
        grown = grown + np.log(np.abs(np.diag(sizes)))
        if k == looks // 2:
            half = grown
    return np.sort((grown - half) / (abs(last) / 2))[::-1]


def _judged(
    stability: Known,
    about: str,
    growth: float,
    exponent: float,
    error: float,
    length: float,
    unit: float,
) -> tuple[str, str]:
    """The verdict and why: by what is known, else by the growth over so many units of time."""
    if stability.rate == 0:
        return (
            REGULAR,
            f"{about}nearby motions separate no faster than a power of t, by {stability.words}",
        )
    if _grows(growth, exponent, error):
        return of_growing(bool(about)), f"{about}nearby motions separate exponentially"
    if stability.rate:
        pace = f"like exp({stability.rate / unit:.3g} t), by {stability.words}"
        return of_growing(bool(about)), f"{about}nearby motions separate {pace}"
    if growth < REGULAR_GROWTH and length >= SHORTEST and not stability.tends:
        return REGULAR, f"{about}{_POWER}"
    return UNDECIDED, about


def _deciding(stability: Known, body: Body, state: Doubles, reached: float, slow: float) -> float:
    """An end that may decide.

    Of a motion that tends to another one, which stands still, by the rate there.
    """
    rate = growth_about(body, state) if stability.tends else 0.0
    sure = 2 * (UNSTABLE_GROWTH + 1) / rate if rate > 0 else SHORTEST * slow
    return sure if sure > reached else 2 * reached


def _grows(growth: float, exponent: float, error: float) -> bool:
    return growth > UNSTABLE_GROWTH and exponent > 4 * error


def is_chaotic(scene: Scene, growth: float, exponent: float, error: float) -> bool:
    """Whether the verdict on a motion whose tangent grows so, which :func:`fitted` tells, is that.

    The scene is looked at only where the growth asks for it.
    """
    return _grows(growth, exponent, error) and not is_known(scene)


def is_known(scene: Scene) -> bool:
    """Whether a scene's motion is a fixed point or has a closed form: it is not called chaotic."""
    return at_rest(scene).state or reference(scene).is_closed_form


def scatter(exponents: Sequence[float]) -> float:
    """The uncertainty of a chaotic motion's exponent: the spread of it and its neighbours'."""
    return float(np.std(exponents, ddof=1))


def fitted(sizes: list[float], length: float) -> tuple[float, float, float]:
    """Mean slope of ln |tangent| over the second half, its uncertainty, and the growth there.

    The largest size in each block stands for it, for the tangent swings with the motion.
    """
    if len(sizes) < 2 * BLOCKS // LOOKS:
        return 0.0, math.inf, 0.0
    tops = [max(part) for part in np.array_split(sizes, min(BLOCKS, len(sizes) // 2))]
    half = tops[len(tops) // 2 - 1 :]
    width = length / len(tops)
    slopes = np.diff(half) / width
    spread = float(np.std(slopes, ddof=1)) / math.sqrt(len(slopes))
    return float(np.mean(slopes)), spread + 2 / length, half[-1] - half[0]


def _size(flow: Variations) -> float:
    """ln of the tangent's length."""
    length = float(np.linalg.norm(flow.tangents))
    return math.log(length) + float(flow.exponent) * math.log(2)
