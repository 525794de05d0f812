"""Certificates of chaos with one number changed: nothing false is proved.

A guess that is changed proves the same statement or nothing.  A statement that is changed is true
where it says less than what was proved.  A body or level whose number is another, has another sign,
is 2 or is 0 is one that the sets do not fit; one that differs by 1e-9 has the same chaos, for the
sets are wider than that moves them.

An image is a function of a transit, a set and two charts: those that a change leaves alone are
remembered, so that a certificate costs its changed images and not all of them.
"""

import copy
import json
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from flint import arb, arb_mat, ctx

from polhode.certificates import verify
from shared.tools import answer, leaves

FILE = Path(__file__).parents[2] / "cases" / "certificates" / "chaos.json"
#: By kind: the parts of the file that are changed.
KINDS = {
    "charts": ("charts",),
    "sets": ("sets",),
    "chain": ("sets", "charts", "transits"),  # two of these change places
    "times": ("transits",),
    "claims": ("statement",),
    "scene": ("scene",),
}
CHANGES = ("1e-9", "sign", "2", "0")
BOUNDS = {"entropy": 1, "short": -1, "long": -1}  # a larger one says more, or less


def changed(number: int | str, how: str) -> int | str:
    """A number by 1e-9 of itself larger, of the other sign, 2 or 0, as it was written."""
    x = Fraction(number)
    values = {"1e-9": x * (1 + Fraction(1, 10**9)), "sign": -x, "2": Fraction(2), "0": Fraction(0)}
    return round(values[how]) if isinstance(number, int) else str(values[how])


def mutated(seed: int, kind: str, certificate: dict[str, Any]) -> tuple[tuple[Any, ...], str]:
    """A certificate with one change; where, and how."""
    chance = random.Random(f"{kind} {seed}")
    if kind == "chain":
        part = chance.choice(KINDS[kind])
        i, j = chance.sample(range(len(certificate[part])), 2)
        certificate[part][i], certificate[part][j] = certificate[part][j], certificate[part][i]
        return (part, i, j), "exchanged"
    part = KINDS[kind][0]
    paths = [path for path in leaves(certificate[part]) if path[-1] != "chart"]
    if kind == "times":
        paths = [path for path in paths if path[1] == "grid"]
    path = paths[chance.randrange(len(paths))]
    how = CHANGES[seed % len(CHANGES)]
    parent = certificate[part]
    for key in path[:-1]:
        parent = parent[key]
    parent[path[-1]] = changed(parent[path[-1]], how)
    return (part, *path), how


IMAGES: dict[Any, verify.Image] = {}


def text_of(value: Any) -> Any:
    """All that a value of the checker's says, exactly."""
    if isinstance(value, arb):
        return value.mid().man_exp(), value.rad().man_exp()
    if isinstance(value, arb_mat):
        return text_of(value.table())
    return tuple(map(text_of, value)) if isinstance(value, (list, tuple)) else value


@pytest.fixture
def remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Images that were made before are not made again."""
    image_of = verify._image

    def image(run: verify.Run, *arguments: Any) -> verify.Image:
        guesses = (run.bits, run.time_bits, run.grid, run.centres, run.inertia, run.torque)
        key = text_of((*guesses, *arguments[:-1]))
        if key not in IMAGES:
            IMAGES[key] = image_of(run, *arguments)
        ctx.prec = run.bits
        return IMAGES[key]

    monkeypatch.setattr(verify, "_image", image)


def check(seed: int, kind: str) -> bool:
    """Whether a changed certificate is proved; asserts that what is, is true."""
    certificate = json.loads(FILE.read_text())
    changed_one = copy.deepcopy(certificate)
    where, how = mutated(seed, kind, changed_one)
    if answer(changed_one).startswith("refused"):
        return False
    if changed_one == certificate:
        return True
    if kind == "claims":
        name = where[1]
        more = Fraction(changed_one["statement"][name]) - Fraction(certificate["statement"][name])
        # what is stated is rounded to two or six digits; less than 1e-9 is left above it
        room = Fraction(certificate["statement"][name]) * Fraction(1, 10**4)
        assert BOUNDS[name] * more <= room, (where, how)
    elif kind == "scene":
        assert how == "1e-9", (where, how)
    else:
        assert changed_one["statement"] == certificate["statement"]
        assert changed_one["scene"] == certificate["scene"]
    return True


@pytest.mark.parametrize("kind", ["scene", "claims", "sets"])
def test_a_changed_certificate_proves_nothing_false(kind):
    check(1, kind)  # a sign


def a_thousand_changed_certificates_prove_nothing_false(kind, first):
    for seed in range(first, first + 8):
        check(seed, kind)
