"""Conventions that somebody told, ``degrees, scalar-last, y up``: applied, whatever they give."""

from __future__ import annotations

import re
from collections.abc import Collection

from polhode.common.errors import BadInput, listed
from polhode.judging.diagnosis.conventions import AnyReference, other_times, right_at, whole_parts
from polhode.judging.diagnosis.reading import as_read
from polhode.judging.diagnosis.time_unit import UNITS
from polhode.judging.diagnosis.ways import Right, as_it_stands, ways
from polhode.judging.tables.candidate import Subject
from polhode.judging.tables.reading import WHOLE_TURNS, Reading, TimeChange
from polhode.numbers.rows import Doubles

#: Other words for the same.
_SAME = {
    "deg": "degrees",
    "deg/s": "degrees",
    "scalar last": "scalar-last",
    "qw last": "scalar-last",
    "conjugate": "body from space",
    "backward": "t of the other sense",
    "ms": "t milliseconds",
    "whole turns": WHOLE_TURNS,
}
_UP = [f"{axis} {sense}" for axis in "xyz" for sense in ("up", "down")]
_TIMES = ["t of the other sense", "one step of t late", "one step of t early"]
_KNOWN = [
    *("degrees", "rpm", "revolutions", "of the other sense", "p q r = q p -r"),
    *("the downward vertical", "gamma1 gamma2 gamma3 = gamma1 -gamma2 -gamma3"),
    *("scalar-last", "q1 the scalar", "body from space", "body x y z = x -y -z", *_UP[:-2]),
    *("z down", WHOLE_TURNS, *_TIMES, *(f"t {unit.name}" for unit in UNITS)),
]
_VERTICAL = re.compile(r"space x y z = [-xyz ]+")  # which the rows tell, where its name was told


def read_as_told(subject: Subject, reference: AnyReference, told: str) -> Subject:
    """A table in conventions separated by commas, in the words by which readings are told.

    Raises BadInput for one that is none of the table's parts.
    """
    phrases = _phrases(told)
    if WHOLE_TURNS in phrases and subject.angles is not None:  # which the judgement itself allows
        del phrases[WHOLE_TURNS]
        if not phrases:
            return subject
    if not phrases:
        raise BadInput(subject.name, "read", told, f"conventions: {', '.join(_KNOWN)}")
    later = dict(other_times(subject, reference.scene, far=True))
    moved = next((later[phrase] for phrase in phrases if phrase in later), None)
    parts, times = whole_parts(subject)
    right = right_at(reference, [t if moved is None else moved.of(t) for t in times], moved)
    if right is None:
        raise BadInput(subject.name, "read", told, "numbers that can be followed in double")
    found = [
        reading
        for part, values in parts.items()
        if (reading := _reading(part, values, right, phrases, moved)) is not None
    ]
    known = [word for word in phrases if word in later]
    if known and not found:
        digits = [as_it_stands(part, values, right) for part, values in parts.items()]
        least = min((d for d in digits if d is not None), default=0.0)
        found.append(Reading("t", 0.0, known[0], least, None, moved))
    for phrase in phrases:
        if phrase not in known and not any(_held(phrase, one.convention) for one in found):
            expected = f"conventions of its parts: {listed(phrase, _KNOWN)}"
            raise BadInput(subject.name, "read", phrase, expected)
    return as_read(subject, found)


def allows_turns(told: str) -> bool:
    """Whether angles are to be read up to whole turns."""
    return WHOLE_TURNS in _phrases(told)


def _phrases(told: str) -> dict[str, None]:
    return dict.fromkeys(_plain(text) for text in told.split(",") if text.strip())


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
    return Reading(part, before, way.words, way.digits, way.change, moved)


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
    return rf"(?<![^ ,]){re.escape(phrase)}(?![^ ,])"
