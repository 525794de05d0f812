"""The verbs that are functions: a row each.  The others have a module of their own here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from polhode.verbs.scene_options import FORM, OUTPUTS, TIMES

_RANGE = {"metavar": "A:B", "help": "the range that a figure shows"}
_TITLE = {"--title": {"metavar": "TEXT", "help": "of a figure, in place of its own"}}
_CMAP = {"metavar": "NAME", "help": "matplotlib's colours of a figure (viridis)"}


class Verb(NamedTuple):
    """What makes a verb of a function.

    ``home``, ``function``: where it is.  ``kind``: the class of its result.  ``named``: options
    whose names differ from the parameters'; one without dashes is an argument, None for none.
    ``scene``: options that change the scene before the function takes it.  ``counts``: what its
    progress counts.  ``own``: the ending of a file of the kind's own, which a stream gets, too;
    ``checks``: whether that is a certificate whose check takes long.  ``is_box``: whether its
    scene's start may be a box.  ``other_kinds``: of the result where a parameter is given.
    ``prints_rows``: whether it prints rows that a file of its data has, too, and then leaves them
    out; what another verb prints is printed with ``-o``, too.  ``figure_options``: None where it
    has no figure.
    """

    name: str
    home: str
    function: str
    kind: str
    help: str
    named: Mapping[str, str | None] = {}
    scene: Sequence[str] = ()
    counts: str = "steps"
    own: str = ""
    checks: bool = False
    is_box: bool = False
    other_kinds: Mapping[str, str] = {}
    prints_rows: bool = False
    figure_options: Mapping[str, Mapping[str, Any]] | None = _TITLE


_MOTION = "angles (default), omega, momentum, attitude, hodographs, sphere, integrals or error"
_MAP = "fli (default), megno, exponent or verdict"


def _what(words: str) -> Mapping[str, str]:
    return {"metavar": "WORD", "help": f"what a figure shows: {words}"}


ROWS = (
    Verb(
        *("list", "polhode.output.cases", "cases", "Cases"),
        "the cases that ship, with regime and reference",
        figure_options=None,
        prints_rows=True,
    ),
    Verb(
        *("show", "polhode.output.description", "describe", "Description"),
        "body, regime, integrals, frequencies, columns to be integrated",
        figure_options=None,
    ),
    Verb(
        *("check", "polhode.checks.check_report", "check_cases", "CheckReport"),
        "regression against references and published figures",
        figure_options=None,
    ),
    Verb(
        *("about", "polhode.output.about", "about", "About"),
        "versions, number types, processor, caches; how to cite",
        figure_options=None,
    ),
    Verb(
        *("run", "polhode.judging.adaptive_precision", "integrate", "Trajectory"),
        "integrate a scene",
        {"at": None, "inputs": None, "proved": "--prove"},
        (TIMES, FORM, OUTPUTS),
        figure_options={"--what": _what(_MOTION), **_TITLE},
        prints_rows=True,
    ),
    Verb(
        *("reference", "polhode.judging.reference", "reference_table"),
        "ReferenceTable",
        "the closed form alone, to any number of digits, no integration",
        {"at": None},
        (TIMES,),
        prints_rows=True,
    ),
    Verb(
        *("certify", "polhode.verbs.certify", "certified", "Enclosure"),
        "a proven enclosure of any motion: only proven digits are printed",
        {"certificate": None},
        (TIMES, OUTPUTS),
        own=".json",
        checks=True,
        is_box=True,
        prints_rows=True,
    ),
    Verb(
        *("compare", "polhode.verbs.compare", "judged", "Judgement"),
        "judge a trajectory that another program computed",
        {"scene": "scene"},
    ),
    Verb(
        *("order", "polhode.verbs.compare", "order", "ObservedOrder"),
        "the order of a method, from files that it made with different steps",
        {"scene": "scene"},
        figure_options=None,
    ),
    Verb(
        *("sweep", "polhode.verbs.sweep", "sweep", "Ensemble"),
        "many tops at once, with varied numbers; not projected, not checked",
        scene=(TIMES,),
        figure_options={"--cmap": _CMAP, **_TITLE},
        counts="members",
        other_kinds={"keep": "Reductions"},
        prints_rows=True,
    ),
    Verb(
        *("levels", "polhode.dynamics.levels", "levels", "Levels"),
        "the (f, h) diagram in closed form: permanent rotations, cusps, where a scene lies",
        figure_options={"--f-range": _RANGE, "--h-range": _RANGE, **_TITLE},
    ),
    Verb(
        *("section", "polhode.dynamics.section", "section", "Section"),
        "crossings of a section by many orbits on one level of energy and area",
        counts="orbits",
        prints_rows=True,
    ),
    Verb(
        *("map", "polhode.dynamics.chaos_map", "chaos_map", "ChaosMap"),
        "a chaos map: growth of one tangent per motion, over a grid or two varied numbers",
        figure_options={"--what": _what(_MAP), "--cmap": _CMAP, **_TITLE},
        counts="motions",
    ),
    Verb(
        *("orbit", "polhode.verbs.orbit", "orbit", "Orbit"),
        "a periodic orbit to any number of digits, and its stability",
        own=".toml",
    ),
    Verb(
        *("orbits", "polhode.dynamics.families", "orbit_search", "OrbitSearch"),
        "the periodic orbits of a level, searched from cells of its section",
        prints_rows=True,
    ),
    Verb(
        *("family", "polhode.dynamics.families", "orbit_family", "OrbitFamily"),
        "a family of periodic orbits along the energy or the vertical momentum",
        prints_rows=True,
    ),
    Verb(
        *("frequencies", "polhode.dynamics.frequencies", "frequencies", "Frequencies"),
        "frequency analysis (Laskar) of a motion, from a scene or a trajectory file",
        prints_rows=True,
    ),
    Verb(
        *("verify", "polhode.certificates.verdict", "verify", "Verdict"),
        "check a proof's certificate, by a program of its own",
        figure_options=None,
    ),
    Verb(
        *("prove orbit", "polhode.proofs.prove_orbit", "prove_orbit", "ProvedOrbit"),
        "that a periodic orbit exists, where, how stable it is",
        own=".json",
    ),
    Verb(
        *("prove orbits", "polhode.proofs.prove_orbit", "prove_orbits", "ProvedOrbits"),
        "which orbits of a search of a level exist",
        figure_options=None,
    ),
    Verb(
        *("prove stability", "polhode.proofs.prove_stability", "prove_stability"),
        "ProvedStability",
        "that a periodic orbit is stable for all time",
        own=".json",
    ),
    Verb(
        *("prove chaos", "polhode.proofs.prove_chaos", "prove_chaos", "ProvedChaos"),
        "that the motion on a level is chaotic",
        own=".json",
    ),
)

VERBS = {verb.name: verb for verb in ROWS}

#: Verbs of several words by the first one, and what that is about.
GROUPS = {
    "prove": "proofs: periodic orbits, where they are, which are stable; that a level is chaotic"
}

#: Options of 0.2 that are now elsewhere.
MOVED = {
    "run": {
        "--proved": "--prove",
        "--unproved": "--no-prove",
        "--project-every": "--project N",
    },
    "reference": dict.fromkeys(
        ("--certified", "--events", "--max-seconds", "--max-steps", "--statement"),
        "polhode certify SCENE",
    ),
    "compare": {
        "--orders": "polhode order FILE FILE... SCENE",
        "--steps": "polhode order FILE FILE... SCENE --steps H,H",
    },
    "orbit": {
        "--prove": "polhode prove orbit SCENE",
        "--continue": "polhode family SCENE --by h --to VALUE",
    },
    "levels": {"--f": "--f-range A:B", "--h": "--h-range A:B"},
}
