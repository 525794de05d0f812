"""The tables of numbers of an accuracy report: in each the first column is the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from polhode.numbers.conversion import to_double
from polhode.output.accuracy import NUMBERS, Line, Section
from polhode.results.cells import DOUBLE, TEXT
from polhode.results.table import Table, table_of_rows

SHOWN = 4  # digits, where people read them

_Row = tuple[Any, ...]


class _Maker(NamedTuple):
    """What makes a table: its columns of texts, then those of numbers, and a scene's rows."""

    texts: str
    numbers: str
    rows: Callable[[Section], Iterator[_Row]]


def tables(sections: Sequence[Section]) -> Mapping[str, Table]:
    """All of them by name."""
    found = {}
    for name, (texts, numbers, rows) in _MAKERS.items():
        types = dict.fromkeys(["scene", *texts.split()], TEXT)
        types |= dict.fromkeys(numbers.split(), DOUBLE)
        every = [(x.scene.name, *row) for x in sections for row in rows(x)]
        columns = table_of_rows(types, every).columns
        found[name] = Table([column._replace(digits=SHOWN) for column in columns])
    return found


def _overview(of: Section) -> Iterator[_Row]:
    fewest = {line.name: line.fewest for line in of.lines}
    judged = [x.judgement for x in of.lines if x.judgement is not None]
    limit = judged[0].limit if judged else ""
    kind = of.reference.kind, of.reference.regime, of.motion.verdict
    files = min((d for x in of.files if (d := x.fewest) is not None), default=None)
    yield (of.verdict, limit, *kind, *map(fewest.get, NUMBERS), len(of.files), files)


def _runs(of: Section) -> Iterator[_Row]:
    for line in of.lines:
        run = line.run
        texts = ("", "") if run is None else (run.number.name, run.method)
        steps = None if run is None else run.steps
        until = None if line.until is None else to_double(line.until)
        yield (line.name, *texts, _limit(line), line.why, steps, *_digits_of(of, line), until)


def _files(of: Section) -> Iterator[_Row]:
    for line in of.files:
        reading = "" if line.judgement is None else line.judgement.reading or ""
        texts = line.mark(of.wanted), _limit(line), reading, line.sentence
        yield (line.name, *texts, *_digits_of(of, line), line.given and line.given.seconds)


def _limit(line: Line) -> str:
    return "" if line.judgement is None else line.judgement.limit


def _digits_of(of: Section, line: Line) -> _Row:
    """The fewest digits, when, those at the end, and when half of them and all are lost."""
    if line.judgement is None or line.fewest is None:
        return (None,) * 3 + of.reach(line)
    worst = line.judgement.worst, to_double(line.judgement.worst_time)
    return (*worst, line.digits[-1], *of.reach(line))


def _digits(of: Section) -> Iterator[_Row]:
    for line in (*of.lines, *of.files):
        if line.judgement is None:
            continue
        times = line.judgement.times
        bands = (line.run and line.judgement.expected) or (None,) * len(times)
        for t, d, band in zip(times, line.digits, bands, strict=True):
            edges = (None, None) if band is None else (band.least, band.most)
            yield (line.name, to_double(t), d, *edges)


def _drift(of: Section) -> Iterator[_Row]:
    if of.unprojected is not None and of.unprojected.times:
        yield (f"{of.unprojected.number.name}, not projected", *of.unprojected.drift)
    for line in (*of.lines, *of.files):
        drift = line.run.drift if line.run else line.judgement and line.judgement.drift
        if drift:
            yield (line.name, *drift)


def _events(of: Section) -> Iterator[_Row]:
    for line in of.lines:
        for event in line.run.events if line.run else ():
            columns = event.signs, event.uncertainty, event.depths
            for k, row in enumerate(zip(*columns, strict=True)):
                yield (line.name, event.name, event.shown(k), k + 1, *row)


def _work(of: Section) -> Iterator[_Row]:
    yield from of.work
    for line in of.files:
        if line.fewest is not None and line.given and line.given.seconds is not None:
            yield (line.name, None, line.digits[-1], line.given.seconds)


def _orders(of: Section) -> Iterator[_Row]:
    for order in of.orders:
        if not isinstance(order, str):
            yield (", ".join(order.names), order.order, order.least, order.most)


_KNOWN = "digits t_of_digits digits_end half_lost_after lost_after"
_MAKERS = {
    "overview": _Maker(
        "verdict limit reference regime motion",
        f"{' '.join(f'digits_{x}' for x in NUMBERS)} files digits_files",
        _overview,
    ),
    "runs": _Maker("run number method limit remark", f"steps {_KNOWN} judged_until", _runs),
    "digits": _Maker("of", "t correct_digits digits_expected_least digits_expected_most", _digits),
    "drift": _Maker("of", "h f gamma fourth", _drift),
    "events": _Maker("run event t", "count sign uncertainty depth", _events),
    "work": _Maker("of", "tolerance digits seconds", _work),
    "files": _Maker("file verdict limit reading sentence", f"{_KNOWN} seconds", _files),
    "orders": _Maker("files", "order order_least order_most", _orders),
}
