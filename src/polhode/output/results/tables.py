"""Each kind of result as a table: columns by name, what they are indexed by first.

One entry a kind of result.  A CSV file, a DataFrame, a Dataset and a Parquet file all have these
columns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from polhode.common.errors import BadInput
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.number_types import LOG10_2
from polhode.output.results.texts import text_of
from polhode.output.sweeps import spread
from polhode.results.result import Storable
from polhode.scenes.vocabulary import COLUMNS, STATE

if TYPE_CHECKING:
    from polhode.dynamics.chaos.chaos_map import ChaosMap
    from polhode.dynamics.frequencies.frequencies import Frequencies
    from polhode.dynamics.levels.levels import Levels
    from polhode.dynamics.observables.reduce_many import Reductions
    from polhode.dynamics.periodic_orbits.families import FamilyPoint, OrbitFamily
    from polhode.dynamics.periodic_orbits.orbit import Orbit
    from polhode.dynamics.periodic_orbits.search import OrbitSearch
    from polhode.dynamics.sections.section import Section
    from polhode.enclosures.events import CertifiedEvents
    from polhode.enclosures.result import Enclosure
    from polhode.judging.conditioning.lyapunov import Lyapunov
    from polhode.judging.references.certified import Certified
    from polhode.judging.references.reference import Reference
    from polhode.judging.score.judgement import Judgement
    from polhode.motion.outcomes import EventTimes
    from polhode.proofs.proved_orbit import ProvedOrbit

#: A number of any type, or a text.
Value: TypeAlias = Any

REFERENCE_DIGITS = 30


class Table(NamedTuple):
    """Columns of equal length by name; the first ``labels`` of them tell the rows apart.

    ``texts``: how columns are written that are not written in full.
    """

    labels: int
    columns: Mapping[str, Sequence[Value]]
    texts: Mapping[str, Sequence[str]] = MappingProxyType({})

    def rows(self) -> list[list[str]]:
        """Header and rows as text; numbers round-trip, empty where there is none."""
        texts = [self.texts.get(name) or text_of(x) for name, x in self.columns.items()]
        return [[*self.columns], *(list(row) for row in zip(*texts, strict=True))]


def table(found: Storable) -> Table:
    """The table of a result; raises BadInput for one that has none."""
    make = KINDS.get(type(found).__name__)
    if make is None:
        raise BadInput(type(found).__name__, "table", None, "a kind of result that has a table")
    return make(found)


def _section(found: Section) -> Table:
    there = np.arange(found.times.shape[1]) < found.counts[:, None]
    orbit, crossing = np.nonzero(there)
    states = {name: found.states[..., k][there] for k, name in enumerate(STATE)}
    columns: dict[str, Value] = {"orbit": orbit + 1, "crossing": crossing + 1}
    columns |= {"t": (found.times + found.rests)[there], "l": found.l[there]}
    return Table(2, columns | {"L_over_G": found.ratio[there]} | states)


def _map(found: ChaosMap) -> Table:
    verdicts = [found.words[k] for k in found.verdict]
    columns: dict[str, Value] = {"motion": np.arange(1, len(verdicts) + 1)}
    columns |= {key: found.at[:, k] for k, key in enumerate(found.keys)}
    columns |= {"cell": found.cell, "verdict": verdicts}
    names = ("fli", "megno", "growth", "exponent", "until")
    return Table(1, columns | {name: getattr(found, name) for name in names})


def _levels(found: Levels) -> Table:
    counts = [len(curve.points) for curve in found.curves]
    points = np.concatenate([curve.points for curve in found.curves])
    each = [k for k, n in enumerate(counts) for _ in range(n)]
    columns: dict[str, Value] = {"curve": [k + 1 for k in each]}
    columns |= {"point": [i + 1 for n in counts for i in range(n)]}
    columns |= {"family": [found.curves[k].family for k in each]}
    columns |= {"type": [found.curves[k].type for k in each]}
    return Table(2, columns | {"f": points[:, 0], "h": points[:, 1]})


def _frequencies(found: Frequencies) -> Table:
    from polhode.output.frequencies import words

    rows = [(name, k + 1, x) for name, lines in found.lines.items() for k, x in enumerate(lines)]
    columns: dict[str, Value] = {"signal": [r[0] for r in rows], "line": [r[1] for r in rows]}
    columns |= {"frequency": [r[2].frequency for r in rows], "error": [r[2].error for r in rows]}
    columns |= {"amplitude": [abs(r[2].amplitude) for r in rows]}
    columns |= {"phase": [float(np.angle(r[2].amplitude)) for r in rows]}
    return Table(2, columns | {"combination": [words(r[2].combination) for r in rows]})


def _orbit(found: Orbit) -> Table:
    state = [*found.scene.omega, *(found.scene.gamma or ())]
    near = {name: [_wide(x, found.digits)] for name, x in zip(STATE, state, strict=True)}
    columns: dict[str, Value] = {"orbit": [1], "period": [_wide(found.period, found.digits)]}
    columns |= {"h": [to_double(found.h)], "f": [to_double(found.f)], "kind": [found.kind]}
    return Table(1, columns | {"residue": [found.residue], "error": [found.error]} | near)


def _points(points: Sequence[FamilyPoint]) -> Table:
    columns: dict[str, Value] = {"orbit": [*range(1, len(points) + 1)]}
    names = ("h", "f", "period", "residue", "kind")
    columns |= {name: [getattr(point, name) for point in points] for name in names}
    states = {name: [float(x.state[k]) for x in points] for k, name in enumerate(STATE)}
    return Table(1, columns | states)


def _family(found: OrbitFamily) -> Table:
    return _points(found.points)


def _search(found: OrbitSearch) -> Table:
    return _points(found.orbits)


def _reductions(found: Reductions) -> Table:
    columns: dict[str, Value] = {"member": [*range(1, len(found) + 1)]}
    values = spread(found.varied, to_double)
    for k, key in enumerate(found.varied.keys):
        columns[key] = values[:, k].tolist()
    return Table(1, columns | dict(found.numbers))


def _enclosure(found: Enclosure) -> Table:
    """Midpoints, written as far as they are proven, radii after all of them."""
    balls = {name: (row, radii) for name, row, radii in _parts(found)}
    columns: dict[str, Value] = {"t": found.times}
    columns |= {name: [_midpoint(found, x) for x in row] for name, (row, _) in balls.items()}
    columns |= {f"radius_{name}": radii for name, (_, radii) in balls.items()}
    texts = {name: _proven(row, radii) for name, (row, radii) in balls.items()}
    return Table(1, columns | {"digits": found.digits}, texts)


def _parts(found: Enclosure) -> Iterator[tuple[str, Sequence[Fraction | None], Sequence[float]]]:
    """The columns of an enclosure: exact midpoints, None where an angle is not known, and radii."""
    yield from _balls(found.scene.columns, found.centres, found.radii)
    parts = {"angles": found.angles, "attitude": found.attitude, **found.derived}
    for word, part in parts.items():
        if part is not None:
            yield from _balls(COLUMNS[word].names, part.centres, part.radii)


def _balls(
    names: Sequence[str],
    centres: Sequence[Sequence[Fraction | None]],
    radii: Sequence[Sequence[float]],
) -> Iterator[tuple[str, Sequence[Fraction | None], Sequence[float]]]:
    for k, name in enumerate(names):
        yield name, [row[k] for row in centres], [row[k] for row in radii]


def _midpoint(found: Enclosure, x: Fraction | None) -> Value:
    from polhode.numbers.conversion import to_mpf
    from polhode.numbers.mpmath_context import ordinary

    return float("nan") if x is None else ordinary(to_mpf(x, found.noise + 128))


def _proven(row: Sequence[Fraction | None], radii: Sequence[float]) -> list[str]:
    """Decimals to which every number of a ball rounds; empty where nothing is known."""
    from polhode.numbers.balls import guaranteed

    return ["" if x is None else guaranteed(x, r) for x, r in zip(row, radii, strict=True)]


def _certified_events(found: CertifiedEvents) -> Table:
    columns: dict[str, Value] = {"event": [*range(1, len(found.times) + 1)]}
    columns |= {"t": [event.time for event in found.times]}
    columns |= {name: [getattr(e, name) for e in found.times] for name in ("radius", "slope")}
    return Table(1, columns)


def _event_times(found: EventTimes) -> Table:
    width = len(found.states[0]) if len(found.states) else 0
    columns: dict[str, Value] = {"event": [*range(1, len(found.times) + 1)], "t": found.t}
    columns |= {name: [row[k] for row in found.states] for k, name in enumerate(STATE[:width])}
    columns |= {"sign": found.signs, "grazing": found.grazing}
    return Table(1, columns | {"uncertainty": found.uncertainty, "depth": found.depths})


def _proved_orbit(found: ProvedOrbit) -> Table:
    balls = dict(zip(("period", "residue"), (found.period, found.residue), strict=True))
    balls |= dict(zip(STATE, (*found.omega, *found.gamma), strict=True))
    digits = round(found.bits * LOG10_2)
    columns: dict[str, Value] = {"orbit": [1], "kind": [found.kind]}
    columns |= {name: [_wide(x.centre, digits)] for name, x in balls.items()}
    columns |= {f"radius_{name}": [x.radius] for name, x in balls.items()}
    return Table(1, columns, {name: [str(x)] for name, x in balls.items()})


def _lyapunov(found: Lyapunov) -> Table:
    columns: dict[str, Value] = {"motion": [1], "verdict": [found.verdict]}
    names = ("exponent", "uncertainty", "growth", "end")
    return Table(1, columns | {name: [getattr(found, name)] for name in names})


def _judgement(found: Judgement) -> Table:
    columns: dict[str, Value] = {"t": found.times}
    if found.digits:
        columns["correct_digits"] = [float("nan") if d is None else d for d in found.digits]
        for k, name in enumerate(("least", "median", "most")):
            columns[f"expected_{name}"] = [
                float("nan") if band is None else band[k] for band in found.expected
            ]
    for name, digits in found.part_digits.items():
        columns[name] = [float("nan") if d is None else d for d in digits]
    return Table(1, columns)


def _reference(found: Reference | Certified) -> Table:
    scene = found.scene
    rows = found.at(scene.times, digits=REFERENCE_DIGITS)
    states = {name: [row[k] for row in rows] for k, name in enumerate(scene.columns)}
    return Table(1, {"t": scene.times, **states})


def _wide(x: Value, digits: int) -> Value:
    """An exact number as an mpf of so many digits and a few."""
    from polhode.numbers.conversion import to_mpf
    from polhode.numbers.mpmath_context import ordinary
    from polhode.numbers.number_types import bits_for

    return ordinary(to_mpf(exactly(x) if not hasattr(x, "enclosure") else x, bits_for(digits + 2)))


#: By the name of the class: a kind that is not asked for is not imported.
KINDS: dict[str, Callable[[Value], Table]] = {
    "Certified": _reference,
    "CertifiedEvents": _certified_events,
    "ChaosMap": _map,
    "Enclosure": _enclosure,
    "EventTimes": _event_times,
    "Frequencies": _frequencies,
    "Judgement": _judgement,
    "Levels": _levels,
    "Lyapunov": _lyapunov,
    "Orbit": _orbit,
    "OrbitFamily": _family,
    "OrbitSearch": _search,
    "ProvedOrbit": _proved_orbit,
    "Reductions": _reductions,
    "Reference": _reference,
    "Section": _section,
}
