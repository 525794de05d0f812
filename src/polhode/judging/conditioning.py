"""How much a motion multiplies relative changes of its inputs, and the digits that this leaves.

kappa(t) = max over i of sum over j of |d x_i / d ln u_j| (t)

x: the state in scene axes, w over the largest |w| at the output times, as in *correct digits*;
u: every input that is not zero, each changed by one unit of itself at once: p q r gamma1 gamma2
gamma3 at the start, the moments A, B, C and the components of Mg r0, all in principal axes, where
the equations are integrated.  Rounding the inputs to eps leaves at most -log10(kappa·eps) digits,
rounding the time a further |state'|·ulp(t).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.arguments import whole
from polhode.equations.equilibrium import at_rest
from polhode.equations.forms import principal
from polhode.equations.system import System, system
from polhode.numbers import exact, number_types
from polhode.numbers.convert import exactly, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import DOUBLE, LOG10_2, NumberType
from polhode.numbers.scalars import FLOATS
from polhode.runs.request import choose_number
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.taylor import policy

MAX_STEPS = 400_000  # of 26 µs: about ten seconds
STRIDE = 8  # units of the scene's own time between looks at the tangents
_DOUBLES_TRUE = 10.0  # log10 of kappa up to which the motion in double is the scene's to 5 digits


@dataclass(frozen=True, repr=False)
class Conditioning:
    """kappa at each time, as far as it was computed.

    ``log10_kappa``: log10 of kappa at each of ``times``, None where it was not computed.
    ``log10_rates``: log10 of |state'|, scaled alike, per unit of the scene's time.  ``lost_after``:
    the time at which kappa·eps of ``number`` reached 1, None where it did not; later times were not
    computed.  ``note``: why others were not, else empty.

    >>> import polhode
    >>> found = polhode.conditioning("euler/separatrix", [10, 120])
    >>> found.digits_possible("double")[1], found.lost
    (0.0, 'no digits left after t = 100')
    """

    scene: Scene
    times: tuple[Exact, ...]
    number: NumberType
    log10_kappa: tuple[float | None, ...]
    log10_rates: tuple[float | None, ...]
    lost_after: float | None
    note: str

    @property
    def kappa(self) -> tuple[float | None, ...]:
        """kappa at each time; inf beyond the range of double."""
        return tuple(None if x is None else _power(x) for x in self.log10_kappa)

    def digits_possible(self, number: NumberType | str | None = None) -> tuple[float | None, ...]:
        """-log10 of kappa·eps + |state'|·ulp(t) at each time, between 0 and what the type holds.

        ``number``: the type asked about, that of the computation unless given.  0 where all are
        lost, None where kappa was not computed.
        """
        if number is None:
            number = self.number
        elif isinstance(number, str):
            number = number_types.named(number)
        found: list[float | None] = []
        for t, kappa, rate in zip(self.times, self.log10_kappa, self.log10_rates, strict=True):
            if kappa is None or rate is None:
                lost = self.lost_after is not None and abs(to_double(t)) >= abs(self.lost_after)
                found.append(0.0 if lost and number.bits <= self.number.bits else None)
                continue
            inputs = kappa - _limit(number)
            clock = rate + _log2_ulp(t, number) * LOG10_2
            found.append(min(number.most_digits, max(0.0, -_log10_sum(inputs, clock))))
        return tuple(found)

    def __repr__(self) -> str:
        known = [x for x in self.log10_kappa if x is not None]
        largest = f"kappa up to {_power(max(known)):.3g}" if known else "kappa not computed"
        return f"<Conditioning of {self.scene.name}: {largest}>"

    def __str__(self) -> str:
        rows = zip(self.times, self.log10_kappa, self.digits_possible(), strict=True)
        lines = [f"{'t':>14}  {'kappa':>9}  digits possible in {self.number.name}"]
        for t, kappa, digits in rows:
            if kappa is not None:
                lines.append(f"{to_double(t):14g}  {_power(kappa):9.3g}  {digits:.1f}")
        return "\n".join([*lines, *filter(None, (self.lost, self.note))])

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are."""
        after = self.lost_after
        return "" if after is None else f"no digits left after t = {after:.3g}"


def conditioning(
    scene: Scene | str | Path,
    times: Sequence[Any] | None = None,
    number: NumberType | str = DOUBLE,
    max_steps: int = MAX_STEPS,
) -> Conditioning:
    """Kappa of a scene at its times (or others), by the variational equations in double.

    It is followed until kappa·eps of ``number`` reaches 1, and is right to two digits and more:
    where the motion in double is no longer the scene's, it is led along one in a wider type than
    ``number``.  ``max_steps``: beyond so many, "kappa not computed".

    >>> import polhode
    >>> print(polhode.conditioning("euler/separatrix", [10, 20]))
                 t      kappa  digits possible in double
                10       41.2  14.0
                20   1.52e+03  12.5
    """
    scene = library.load(scene)
    if times is not None:
        scene = scene.at(times)
    kind = choose_number(scene, number, None)
    max_steps = whole(scene.name, "max_steps", max_steps, 1)
    unit = Fraction(2) ** scene.time_unit
    outputs = [to_double(t / unit) for t in scene.times]
    asked, looks, note = set(outputs), [], ""
    rates_seen = 0.0
    for look in _looks(scene, outputs, kind, max_steps):
        if isinstance(look, str):
            note = look
            break
        looks.append(look)
        rates_seen = max(rates_seen, look.speed)
        if look.log10_kappa(rates_seen or _pendulum(scene)) > _limit(kind) + 1:
            break
    scale = max((k.speed for k in looks if k.time in asked), default=0.0) or _pendulum(scene)
    lost = _crossing(looks, scale, _limit(kind))
    kept = {k.time: k for k in looks if lost is None or abs(k.time) < abs(lost)}
    found = [kept.get(t) for t in outputs]
    return Conditioning(
        scene,
        scene.times,
        kind,
        tuple(None if k is None else k.log10_kappa(scale) for k in found),
        tuple(
            None if k is None else k.log10_rate(scale) - scene.time_unit * LOG10_2 for k in found
        ),
        None if lost is None else lost * float(unit),
        "" if lost is not None else note,
    )


class Look(NamedTuple):
    """What one moment shows, in the scene's own unit of time and in scene axes."""

    time: float
    speed: float  # |w|
    rates: Any  # the largest of |w'| and of |gamma'|, by component
    sums: Any  # sums over the inputs: the largest for w and for gamma
    exponent: int  # the sums are 2**exponent times these

    def log10_kappa(self, scale: float) -> float:
        """log10 of kappa, w relative to ``scale``."""
        return _log10(max(self.sums[0] / scale, self.sums[1])) + self.exponent * LOG10_2

    def log10_rate(self, scale: float) -> float:
        """log10 of |state'| per own unit of time."""
        return _log10(max(self.rates[0] / scale, self.rates[1]))


def _looks(
    scene: Scene, outputs: list[float], kind: NumberType, max_steps: int
) -> Iterator[Look | str]:
    """Looks at the output times and in between; a last word where it ends early."""
    import numpy as np

    from polhode.taylor.variations import Variations

    plain = system(replace(scene, form="principal"), ())
    body, unit = scene.body, scene.time_unit
    start = six(plain.start)
    tangents = np.hstack([np.diag(start), np.zeros((6, 6))])
    flow = Variations(plain.coefficients, start, tangents, principal.sensitivities(body, unit))
    k = {name: to_double(x) for name, x in plain.coefficients.items()}
    turn = np.array([[to_double(x) for x in row] for row in body.axes.rows]).T
    leader: _Leader | _Still | None = _Still(start) if at_rest(scene).state else None
    for t in _moments(outputs):
        arrived = t == 0 or flow.to(t, max_steps - flow.steps)
        if not (arrived and flow.finite):
            more = flow.steps >= max_steps
            why = f"more than {max_steps} steps" if more else "not finite in double"
            yield f"kappa not computed beyond t = {flow.time * 2.0**unit:.3g}: {why}"
            return
        if leader is not None:
            flow.state = leader.at(t)
        flow.rescale()
        x, v = flow.state, flow.tangents
        rates = np.array(principal.field([float(c) for c in x], k, FLOATS))
        sums = [float(np.max(np.sum(np.abs(turn @ v[i : i + 3]), axis=1))) for i in (0, 3)]
        speeds = [float(np.max(np.abs(turn @ rates[i : i + 3]))) for i in (0, 3)]
        found = Look(t, float(np.linalg.norm(x[:3])), speeds, sums, flow.exponent)
        yield found
        if leader is None and found.log10_kappa(found.speed or 1.0) > _DOUBLES_TRUE:
            leader = _Leader(plain, number_types.wider(kind))
            flow.state = leader.at(t)


class _Leader:
    """The motion in a wider type, asked for at times that grow."""

    def __init__(self, plain: System, number: NumberType) -> None:
        from polhode.taylor.build import build

        self._run, self._steps = build(plain, number), policy.of(number).chunk

    def at(self, time: float) -> Any:
        """The six components of the state at a time, as doubles."""
        rows: Any = []
        while len(rows) == 0:
            rows, _ = self._run.chunk([Fraction(time)], self._steps)
        return six([exactly(x) for x in rows[0]])


class _Still:
    """A state that stays: no rounding moves it."""

    def __init__(self, start: Any) -> None:
        self._start = start

    def at(self, _: float) -> Any:
        """The state, always."""
        return self._start


def six(state: Sequence[Exact]) -> Any:
    """A state as six doubles, gamma zero where there is none."""
    import numpy as np

    return np.array([*(to_double(x) for x in state), *[0.0] * (6 - len(state))])


def _moments(outputs: list[float]) -> Iterator[float]:
    """The output times and every multiple of the stride between them, away from 0."""
    done = 0
    for t in outputs:
        while (done + 1) * STRIDE < abs(t):
            done += 1
            yield math.copysign(done * STRIDE, t)
        if abs(t) == (done + 1) * STRIDE:
            done += 1
        yield t


def _crossing(looks: list[Look], scale: float, limit: float) -> float | None:
    """The time at which log10 of kappa first reaches the limit, between two looks."""
    before, height = 0.0, 0.0
    for look in looks:
        here = look.log10_kappa(scale)
        if here >= limit:
            part = (limit - height) / (here - height) if here > height else 1.0
            return before + min(1.0, max(0.0, part)) * (look.time - before)
        before, height = look.time, here
    return None


def _limit(number: NumberType) -> float:
    """log10 of the kappa at which kappa·eps is 1."""
    return (number.bits - 1) * LOG10_2


def _pendulum(scene: Scene) -> float:
    """The scale of w for a body at rest, in the scene's own unit of time."""
    square = scene.pendulum_rate_squared
    return to_double(exact.sqrt(square * Fraction(4) ** scene.time_unit)) if sign(square) else 1.0


def _log2_ulp(t: Exact, number: NumberType) -> float:
    """log2 of the distance between neighbours at t."""
    if sign(t) == 0:
        return -math.inf
    mantissa, exponent = exact.rounded(t, number.bits)
    return exponent + abs(mantissa).bit_length() - number.bits


def _log10_sum(a: float, b: float) -> float:
    """log10 of 10**a + 10**b."""
    low, high = sorted((a, b))
    return high if low == -math.inf else high + math.log10(1 + 10 ** (low - high))


def _log10(x: float) -> float:
    return math.log10(x) if x > 0 else -math.inf


def _power(log10: float) -> float:
    return 10.0**log10 if log10 < 308 else math.inf
