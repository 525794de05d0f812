"""What a document of a result may hold: classes by name, their fields, and the types of these."""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from functools import cache
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.judging.tables.reading import Reading
from polhode.motion.outcomes import OUTCOMES
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.exact_sequences import Floats, Spaced
from polhode.numbers.number_types import NAMES, SINGLE, named
from polhode.numbers.scalars import Real
from polhode.output.archive import MOST_BITS
from polhode.scenes.validation import MAX_SAMPLES
from polhode.scenes.variation.vary import MAX_MEMBERS

#: Whatever a result holds, and what JSON makes of it.
Value: TypeAlias = Any

#: Where each class is: a document names nothing else.
HOMES = {
    "Bifurcation": "dynamics.periodic_orbits.families",
    "Ball": "proofs.proved_orbit",
    "Body": "scenes.body",
    "Certified": "judging.references.certified",
    "CertifiedEvents": "enclosures.certified_events",
    "Change": "judging.tables.reading",
    "ChaosMap": "dynamics.chaos.chaos_map",
    "Closed": "dynamics.periodic_orbits.newton_shooting",
    "CriticalValue": "dynamics.levels.fourth_integral",
    "Curve": "dynamics.levels.levels",
    "Enclosure": "enclosures.result",
    "Ensemble": "runs.sweep.ensemble",
    "Event": "scenes.event",
    "EventTime": "enclosures.certified_events",
    "EventTimes": "motion.outcomes",
    "FamilyPoint": "dynamics.periodic_orbits.families",
    "Floats": "numbers.exact_sequences",
    "FourthIntegral": "dynamics.levels.fourth_integral",
    "Frequencies": "dynamics.frequencies.frequencies",
    "Grid": "scenes.variation.vary",
    "Here": "dynamics.levels.levels",
    "Judgement": "judging.score.judgement",
    "Levels": "dynamics.levels.levels",
    "Line": "dynamics.frequencies.frequencies",
    "Lyapunov": "judging.conditioning.lyapunov",
    "Mark": "dynamics.levels.levels",
    "Member": "dynamics.periodic_orbits.continuation",
    "Members": "scenes.variation.sweep_scenes",
    "NumberType": "numbers.number_types",
    "ObservedOrder": "judging.convergence_order",
    "Orbit": "dynamics.periodic_orbits.orbit",
    "OrbitFamily": "dynamics.periodic_orbits.families",
    "OrbitSearch": "dynamics.periodic_orbits.search",
    "OutputTimes": "scenes.output_times",
    "Part": "enclosures.result",
    "ProvedOrbit": "proofs.proved_orbit",
    "Published": "scenes.scene",
    "Reading": "judging.tables.reading",
    "Reductions": "dynamics.observables.reduce_many",
    "Rows": "scenes.variation.vary",
    "Scene": "scenes.scene",
    "Section": "dynamics.sections.section",
    "SectionPlan": "scenes.scene",
    "Solid": "scenes.shapes",
    "Spaced": "numbers.exact_sequences",
    "Surface": "dynamics.periodic_orbits.level_set",
    "Table": "judging.tables.table",
    "TimeChange": "judging.tables.reading",
    "Within": "proofs.proved_orbit",
}
_OWN_NAMES = {"Solid": "Part"}  # where two classes have one name
#: Not part of a value: unfinished work, who waits for it, and what is computed again.
_LEFT_OUT = {
    "ChaosMap": ("kept",),
    "Ensemble": ("kept",),
    "Judgement": ("known", "progress"),
    "Reductions": ("kept",),
    "Section": ("kept",),
}
#: The fields of classes that declare none; a word stands for one of these classes.
_FIELDS: dict[str, dict[str, Value]] = {
    "Certified": {"scene": "Scene"},
    "Floats": {"values": np.ndarray},
    "Members": {"scene": "Scene", "varied": "Grid"},
    "OutputTimes": {"numbers": tuple[Exact, ...] | Spaced | Floats},
    "Rows": {"columns": tuple[Sequence[Exact], ...], "product": bool},
    "Spaced": {"first": Exact, "last": Exact, "size": int},
}
_Array = npt.NDArray[Value]
#: What annotations name where it is imported for type checkers alone.
_NAMES: dict[str, Value] = {
    "np": np,
    "npt": npt,
    "Doubles": npt.NDArray[np.float64],
    "Integers": npt.NDArray[np.integer],
    "Complexes": npt.NDArray[np.complex128],
    "Stack": _Array,
    "States": _Array,
    "Given": _Array | Sequence[Sequence[Real | None] | _Array],
    "Reading": Reading,
}


def word_of(x: Value) -> str:
    """The name under which a document has an object; raises TypeError for what it cannot hold."""
    place = type(x).__module__, type(x).__name__
    if place not in _words():
        raise TypeError(f"{place[0]}.{place[1]}: no part of a result")
    return _words()[place]


@cache
def _words() -> dict[tuple[str, str], str]:
    return {(f"polhode.{home}", _OWN_NAMES.get(word, word)): word for word, home in HOMES.items()}


@cache
def _class_of(word: str) -> Value:
    return getattr(import_module(f"polhode.{HOMES[word]}"), _OWN_NAMES.get(word, word))


@cache
def fields_of(word: str) -> dict[str, Value]:
    """The fields of a class that a document holds, with their types, in order."""
    if word in _FIELDS:
        own = _FIELDS[word].items()
        return {name: _class_of(x) if isinstance(x, str) else x for name, x in own}
    made = _class_of(word)
    names = made._fields if issubclass(made, tuple) else [field.name for field in fields(made)]
    hints = typing.get_type_hints(made, localns=_NAMES)
    return {name: hints[name] for name in names if name not in _LEFT_OUT.get(word, ())}


def made(word: str, values: Sequence[Value]) -> Value:
    """The object of a class with these values of its fields; raises ValueError, BadInput."""
    hints = fields_of(word)
    if len(values) != len(hints):
        raise ValueError(f"{word}: {len(values)} fields, not {len(hints)}")
    for (name, hint), value in zip(hints.items(), values, strict=True):
        if not _fits(value, hint):
            raise ValueError(f"{word}.{name}: a value of another type")
    _check_counts(word, values)
    kind = _class_of(word)
    if word in _FIELDS or issubclass(kind, tuple):
        return kind(*values)
    given = dict(zip(hints, values, strict=True))
    later = [field.name for field in fields(kind) if not field.init]
    found = kind(**{name: x for name, x in given.items() if name not in later})
    for name in later:
        object.__setattr__(found, name, given[name])
    _check_shapes(word, found)
    return found


def _check_counts(word: str, values: Sequence[Value]) -> None:
    """Refuse what would be made of very many numbers."""
    if word == "Spaced" and not 1 <= values[-1] <= MAX_MEMBERS:
        raise ValueError(f"{word}: {values[-1]} numbers")
    if word == "OutputTimes" and len(values[0]) > MAX_SAMPLES and isinstance(values[0], Spaced):
        raise ValueError(f"{word}: {len(values[0])} numbers")
    if word == "Rows":
        columns, product = values
        sizes = [len(column) for column in columns]
        count = math.prod(sizes) if product else max(sizes, default=0)
        least = 0 if {type(column).__name__ for column in columns} == {"Floats"} else 1
        if not least <= count <= MAX_MEMBERS or not (product or len(set(sizes)) == 1):
            raise ValueError(f"{word}: columns of {sizes[:4]} values")
    if word == "Floats":
        (floats,) = values
        if floats.ndim != 1 or floats.dtype.kind != "f" or not np.isfinite(floats).all():
            raise ValueError(f"{word}: no column of finite floats")
    if word == "NumberType":
        name, bits = values
        known = {x.name: x.bits for x in (SINGLE, *map(named, NAMES[:3]))}
        if known.get(name, bits) != bits or name not in (*known, "mp") or not 0 < bits <= MOST_BITS:
            raise ValueError(f"{word}: {name} of {bits} bits")


#: The axes of arrays, by letters; one letter is one number in a result.
_AXES = {
    "Ensemble": {"states": "mtc", "endings": "m", "counts": "m", "arrived": "m"},
    "Reductions": {"endings": "m", "counts": "m"},
    "Section": {
        "start_states": "oc",
        "states": "okc",
        "times": "ok",
        "rests": "ok",
        "l": "ok",
        "ratio": "ok",
        "counts": "o",
    },
    "ChaosMap": dict.fromkeys(("verdict", "fli", "megno", "growth", "exponent", "until"), "n"),
}


def _check_shapes(word: str, found: Value) -> None:
    """Refuse arrays that do not belong together."""
    sizes: dict[str, int] = {}
    if word in ("Ensemble", "Reductions"):
        members = found.members
        scene = replace(found.scene, events=())  # no member has events of its own
        if members.scene != scene or members.varied != found.varied:
            raise ValueError(f"{word}.members: of another scene")
        sizes["m"] = len(members)
        for k in (0, -1) if sizes["m"] else ():  # which refuse keys that the scene does not have
            members[k]
        if not (found.endings < len(OUTCOMES)).all():
            raise ValueError(f"{word}.endings: unknown")
    if word == "Ensemble":
        sizes |= {"t": len(found.times), "c": len(found.columns)}
    for name, axes in _AXES.get(word, {}).items():
        shape = getattr(found, name).shape
        if len(shape) != len(axes) or any(
            sizes.setdefault(axis, size) != size for axis, size in zip(axes, shape, strict=True)
        ):
            raise ValueError(f"{word}.{name}: of shape {shape}")


def _fits(value: Value, hint: Value) -> bool:
    """Whether a value has the type that an annotation says."""
    origin: Value = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return any(_fits(value, x) for x in arguments)
    if origin is tuple:
        if not isinstance(value, tuple):
            return False
        if arguments[1:] == (Ellipsis,):
            return all(_fits(x, arguments[0]) for x in value)
        return len(value) == len(arguments) and all(map(_fits, value, arguments))
    if origin in (dict, Mapping):
        key, held = arguments
        return isinstance(value, dict) and all(
            _fits(k, key) and _fits(x, held) for k, x in value.items()
        )
    if origin is Sequence:
        if isinstance(value, (list, tuple)):
            return all(_fits(x, arguments[0]) for x in value)
        return isinstance(value, Sequence) and not isinstance(value, str)
    if origin is np.ndarray:
        (element,) = typing.get_args(arguments[1])
        own = isinstance(value, np.ndarray)
        return own and (element is Value or np.issubdtype(value.dtype, element))
    if hint in (float, int, complex):
        kinds = {float: (float, int, np.floating), int: (int, np.integer)}
        return isinstance(value, kinds.get(hint, (complex, float))) and not isinstance(value, bool)
    if getattr(hint, "__name__", "") in ("Real", "mpf"):
        numbers = (int, float, np.number, Fraction, Irrational)
        return hasattr(value, "_mpf_") or (
            isinstance(value, numbers) and not isinstance(value, bool)
        )
    if hint is object:
        return _is_plain(value)
    return hint is Value or isinstance(value, hint)


def _is_plain(value: Value) -> bool:
    """Whether it is text, numbers, truth, or nothing, in lists and tables."""
    if isinstance(value, dict):
        return all(isinstance(k, str) and _is_plain(x) for k, x in value.items())
    if isinstance(value, (list, tuple)):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, (str, int, float))
