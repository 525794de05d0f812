"""Conventions that somebody told, ``degrees, scalar-last, y up``: applied, whatever they give."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

from polhode.common.errors import BadInput, listed
from polhode.judging.diagnosis.conventions import (
    other_times,
    right_at,
    shown_rows,
    whole_parts,
)
from polhode.judging.diagnosis.reading import as_read
from polhode.judging.diagnosis.time_unit import UNITS, told_clock
from polhode.judging.diagnosis.ways import Right, as_it_stands, ways
from polhode.judging.references.reference import AnyReference
from polhode.judging.tables.candidate import Subject, of_table
from polhode.judging.tables.reading import LENGTH, TURNS, Reading, TimeChange
from polhode.judging.tables.table import Table
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import ANGLES, ATTITUDE

#: Other words for the same.
_SAME = {
    "deg": "degrees",
    "deg/s": "degrees",
    "scalar last": "scalar-last",
    "qw last": "scalar-last",
    "conjugate": "body from space",
    "backward": "t of the other sense",
    "ms": "t milliseconds",
    "in degrees": "degrees",
    "whole turns": TURNS,
}
_UP = [f"{axis} {sense}" for axis in "xyz" for sense in ("up", "down")]
_TIMES = ["t of the other sense", "one step of t late", "one step of t early"]
_KNOWN = [
    *("degrees", "rpm", "revolutions", "of the other sense", "p q r = q p -r"),
    *("the downward vertical", "gamma1 gamma2 gamma3 = gamma1 -gamma2 -gamma3"),
    *("scalar-last", "q1 the scalar", "body from space", "body x y z = x -y -z", *_UP[:-2], LENGTH),
    *("z down", *_TIMES, *(f"t {unit.name}" for unit in UNITS), "t - NUMBER"),
]
_VERTICAL = re.compile(r"space x y z = [-xyz ]+")  # which the rows tell, where its name was told
_FROM_FIRST = re.compile(r"(?:t )?from its first row on(?: \(.*\))?")
_UNITS = "degrees|rpm|revolutions"
_AXES = r"=(?: -?[a-z]+\d?){3}"
_FRAMES = rf"[xyz] (?:up|down)|(?:body|space) x y z {_AXES}"
#: The parts that may have a convention, by its words.
_PARTS = {
    "omega": rf"{_UNITS}|(?:of the other sense|p q r {_AXES})(?: (?:{_UNITS}))?",
    "gamma": rf"the downward vertical|gamma1 gamma2 gamma3 {_AXES}",
    "attitude": rf"scalar-last|q1 the scalar|body from space|{_FRAMES}",
    "angles": rf"degrees|{TURNS}",
}
#: Readings that are reported and not applied.
_REPORTED = re.compile(
    r"along the axes of space.*|turns about .*|of either sign.*|a weight .*|products .*|"
    r"the scene's .*|.*a constant rotation of .*|(?:t )?decimals of .*"
)


class _Told(NamedTuple):
    """A convention that was told, and the part that it is told of, empty for every part."""

    part: str
    phrase: str

    def of(self, part: str) -> bool:
        """Whether it is told of a part."""
        return self.part in ("", part)


def read_as_told(subject: Subject, reference: AnyReference, told: str) -> Subject:
    """A table in conventions separated by commas, in the words by which readings are told.

    After a semicolon others may follow; those from the name of a part on, as in "omega degrees;
    attitude scalar-last, y up", are of this part alone.  Raises BadInput for one that is none of
    the table's parts.
    """
    named = _named(subject, told)
    phrases = dict.fromkeys(one.phrase for one in named)
    if not phrases and LENGTH in told:
        return subject
    if not phrases:
        raise BadInput(subject.name, "read", told, f"conventions: {', '.join(_KNOWN)}")
    later = dict(other_times(subject, reference.scene, far=True))
    later |= {phrase: by for phrase in phrases if (by := told_clock(phrase)) is not None}
    for phrase in phrases:
        if phrase not in later:
            _refuse_unknown(subject, phrase)
    moved = next((later[phrase] for phrase in phrases if phrase in later), None)
    parts, times = whole_parts(subject)
    right = right_at(reference, [t if moved is None else moved.of(t) for t in times], moved)
    if right is None:
        raise BadInput(subject.name, "read", told, "numbers that can be followed in double")
    found = [
        reading
        for part, values in parts.items()
        if (reading := _reading(part, values, right, [*_of(named, part)], moved, times)) is not None
    ]
    known = [word for word in phrases if word in later]
    if known and not found:
        digits = [as_it_stands(part, values, right) for part, values in parts.items()]
        least = min((d for d in digits if d is not None), default=0.0)
        found.append(Reading("t", 0.0, known[0].removeprefix("t "), least, None, moved))
    if TURNS in phrases and "angles" in parts and all(one.part != "angles" for one in found):
        before = as_it_stands("angles", parts["angles"], right) or 0.0
        found.append(Reading("angles", before, TURNS, before))
    for one in named:
        if one.phrase not in known and not any(_has(reading, one) for reading in found):
            raise BadInput(subject.name, "read", one.phrase, _expected(one, parts))
    return as_read(subject, found)


def table_as_told(table: Table, reference: AnyReference, told: str) -> Table:
    """A table whose state, angles and attitude are read so; raises BadInput likewise."""
    scene = reference.scene
    subject = read_as_told(of_table(table, scene), reference, told)
    columns = dict(table.columns)
    parts = (
        (scene.columns, subject.states),
        (ANGLES, subject.angles),
        (ATTITUDE, subject.attitude),
    )
    for names, rows in parts:
        for k, name in enumerate(names):
            if rows is not None and name in columns:
                columns[name] = tuple(row[k] for row in rows)
    return replace(table, times=subject.times, columns=columns)


def _named(subject: Subject, told: str) -> list[_Told]:
    """The conventions that are told, in the words that are used here."""
    found = []
    for group in told.split(";"):
        part = ""
        for text in filter(str.strip, re.split(r",(?! from its first row on)(?![^()]*\))", group)):
            phrase = _plain(text)
            first, _, rest = phrase.partition(" ")
            if first in _PARTS and rest:
                part, phrase = first, _plain(rest)
            if phrase == LENGTH:  # applied before
                continue
            if _FROM_FIRST.fullmatch(phrase):
                phrase = f"t from {float(subject.times[0]):.6g} on"
            found.append(_Told(part, phrase))
    return found


def _of(named: Sequence[_Told], part: str) -> Iterator[str]:
    """The conventions that are told of a part."""
    return (one.phrase for one in named if one.of(part))


def _has(reading: Reading, one: _Told) -> bool:
    """Whether a reading has a convention that was told."""
    turned = one.phrase == TURNS and reading.part == "angles"
    return one.of(reading.part) and (turned or _held(one.phrase, reading.convention))


def _refuse_unknown(subject: Subject, phrase: str) -> None:
    """Raise BadInput for words that are no convention, or one that is not applied."""
    if _REPORTED.fullmatch(phrase):
        expected = "a convention that can be applied; this one is reported, and not applied"
        raise BadInput(subject.name, "read", phrase, expected)
    if not any(re.fullmatch(words, phrase) for words in _PARTS.values()):
        raise BadInput(subject.name, "read", phrase, f"conventions: {listed(phrase, _KNOWN)}")


def _expected(one: _Told, parts: Collection[str]) -> str:
    """What a table would need to be read in a convention."""
    may = [part for part, words in _PARTS.items() if re.fullmatch(words, one.phrase)]
    if one.part and one.part not in may:
        return f"a convention of {one.part}; this one is of {' or '.join(may)}"
    wanted = [one.part] if one.part else may
    if not {*wanted} & {*parts}:
        return f"{' or '.join(wanted)} in every row; the table has {', '.join(parts) or 'none'}"
    if re.fullmatch(_FRAMES, one.phrase):
        return "a quaternion that nearly has the first row's attitude in it, in right-handed axes"
    return f"three rows or more, and no second convention of that kind for {' or '.join(wanted)}"


def _plain(text: str) -> str:
    """A convention in the words that are used here."""
    words = " ".join(text.split())
    spaced = re.sub(r"^([xyz])-(up|down)$", r"\1 \2", words)
    return _SAME.get(spaced, spaced)


def _reading(
    part: str,
    values: Doubles,
    right: Right,
    phrases: Collection[str],
    moved: TimeChange | None,
    times: Sequence[Fraction],
) -> Reading | None:
    """A part in the most of these conventions that are of it, and in no other."""
    found = [
        (count, way)
        for way in ways(part, values, right)
        if way.change is not None and (count := _count(way.words, phrases))
    ]
    before = as_it_stands(part, values, right)
    if not found or before is None:
        return None
    _, way = max(found, key=lambda one: (one[0], one[1].digits))
    told = shown_rows(way, times)
    return Reading(part, before, way.words, way.digits, way.change, moved, told)


def _count(words: str, phrases: Collection[str]) -> int:
    """How many conventions a way's words are made of; 0 where they have another, too."""
    left, count = words, 0
    for phrase in phrases:
        if _held(phrase, left):
            left, count = re.sub(_pattern(phrase), "", left), count + 1
            if phrase in _UP:
                left = _VERTICAL.sub("", left)
    return 0 if left.strip(" ,") else count


def _held(phrase: str, words: str) -> bool:
    return re.search(_pattern(phrase), words) is not None


def _pattern(phrase: str) -> str:
    """A phrase of whole words."""
    before = "(?:in )?" if phrase == "degrees" else ""
    return rf"(?<![^ ,]){before}{re.escape(phrase)}(?![^ ,])"
