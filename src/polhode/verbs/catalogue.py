"""The verbs: a row each, with one example, in the order in which --help lists them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from polhode.verbs.scene_options import FORM, OUTPUTS, TIMES

_RANGE = {"metavar": "A:B", "help": "the range that a figure shows"}
_TITLE = {"--title": {"metavar": "TEXT", "help": "of a figure, in place of its own"}}
_CMAP = {"metavar": "NAME", "help": "matplotlib's colours of a figure (viridis)"}


class Verb(NamedTuple):
    """What makes a verb.

    ``home``, ``function``: the function that it calls, whose parameters are its options; where
    there is no ``kind`` of result, that carries it out itself, and ``add_<function>`` of the same
    module adds its options.  ``example``: what may follow ``polhode``; each reads what those above
    it wrote.  ``named``: options whose names differ from the parameters'; one without dashes is an
    argument, None for none.  ``scene``: options that change the scene before the function takes it.
    ``notes``: the function of :mod:`polhode.verbs.notes` that tells of its result.  ``counts``:
    what its progress counts.  ``own``: the endings of files of the kind's own, of which a stream
    gets the first; ``checks``: whether that is a certificate whose check takes long.  ``is_box``:
    whether its scene's start may be a box.  ``other_kinds``: of the result where a parameter is
    given, or the verb whose result it then is.
    ``prints_rows``: whether it prints rows that a file of its data has, too, and then leaves them
    out; what another verb prints is printed with ``-o``, too.  ``figure_options``: None where it
    has no figure.
    """

    name: str
    home: str
    function: str
    kind: str
    help: str
    example: str
    named: Mapping[str, str | None] = {}
    scene: Sequence[str] = ()
    notes: str = "nothing"
    counts: str = "steps"
    own: Sequence[str] = ()
    checks: bool = False
    is_box: bool = False
    other_kinds: Mapping[str, str] = {}
    prints_rows: bool = False
    figure_options: Mapping[str, Mapping[str, Any]] | None = _TITLE

    @property
    def command(self) -> str:
        """The example in full."""
        return f"polhode {self.name} {self.example}".rstrip()


_MOTION = "angles (default), omega, momentum, attitude, hodographs, sphere, integrals or error"
_MAP = "fli (default), megno, exponent or verdict"
_PLOT, _FUNCTIONS, _PROOFS = "polhode.verbs.plot", "polhode.verbs.functions", "polhode.proofs"


def _figure_word(words: str) -> Mapping[str, str]:
    return {"metavar": "WORD", "help": f"what a figure shows: {words}"}


ROWS = (
    Verb(
        *("list", "polhode.output.cases", "cases", "Cases"),
        "the cases that ship, with regime and reference",
        "--tag chaotic",
        figure_options=None,
        prints_rows=True,
    ),
    Verb(
        *("show", "polhode.output.description", "describe", "Description"),
        "body, regime, integrals, frequencies, columns to be integrated",
        "lagrange/nutation",
        figure_options=None,
    ),
    Verb(
        *("new", "polhode.verbs.new", "new", ""),
        "a commented scene file to begin with, from a case or a shape",
        "top.toml --cone '3 cm,5 cm,50 g' --end '0.5 s'",
    ),
    Verb(
        *("run", "polhode.judging.adaptive_precision", "integrate", "Trajectory"),
        "integrate a scene",
        "top.toml --samples 51 -o top.csv",
        {"at": None, "inputs": None, "proved": "--prove"},
        (TIMES, FORM, OUTPUTS),
        notes="run",
        figure_options={"--what": _figure_word(_MOTION), **_TITLE},
        prints_rows=True,
    ),
    Verb(
        *("reference", "polhode.judging.reference", "reference_table", "ReferenceTable"),
        "the closed form alone, to any number of digits, no integration",
        "euler/separatrix --at 1 --digits 40",
        {"at": None},
        (TIMES,),
        notes="reference",
        prints_rows=True,
    ),
    Verb(
        *("certify", _FUNCTIONS, "certified", "Enclosure"),
        "a proven enclosure of any motion: only proven digits are printed",
        "general/asymmetric-regular --at 1 --digits 20 -o state.json",
        {"certificate": None},
        (TIMES, OUTPUTS),
        notes="certified",
        own=(".json",),
        checks=True,
        is_box=True,
        prints_rows=True,
    ),
    Verb(
        *("check", "polhode.checks.check_report", "check_cases", "CheckReport"),
        "regression against references and published figures",
        "euler/rest",
        notes="check",
        figure_options=None,
    ),
    Verb(
        *("compare", _FUNCTIONS, "judged", "Judgement"),
        "judge a trajectory that another program computed",
        "top.csv top.toml",
        {"scene": "scene", "whole": None},
    ),
    Verb(
        *("order", _FUNCTIONS, "order", "ObservedOrder"),
        "the order of a method, from files that it made with different steps",
        "coarse.csv fine.csv lagrange/nutation --steps 0.02,0.01",
        {"scene": "scene"},
        figure_options=None,
    ),
    Verb(
        *("sweep", _FUNCTIONS, "sweep", "Ensemble"),
        "many tops at once, with varied numbers; not projected, not checked",
        "lagrange/nutation --vary 'start.omega[3]=2:4:3' --at 0,1 -o sweep.csv",
        scene=(TIMES,),
        notes="sweep",
        figure_options={"--cmap": _CMAP, **_TITLE},
        counts="members",
        other_kinds={"keep": "Reductions"},
        prints_rows=True,
    ),
    Verb(
        *("plot", _PLOT, "plot", ""),
        "a figure of a motion or a result, from a scene or a file",
        "top.toml --what omega -o top.svg",
    ),
    Verb(
        *("view", _PLOT, "view", ""),
        "motions as one animated HTML page that needs nothing else",
        "top.toml -o top.html",
    ),
    Verb(
        *("levels", "polhode.dynamics.levels", "levels", "Levels"),
        "the (f, h) diagram in closed form: permanent rotations, cusps, where a scene lies",
        "general/asymmetric-regular",
        figure_options={"--f-range": _RANGE, "--h-range": _RANGE, **_TITLE},
    ),
    Verb(
        *("section", "polhode.dynamics.section", "section", "Section"),
        "crossings of a section by many orbits on one level of energy and area",
        "general/asymmetric-regular --grid 2x2 --crossings 3 -o section.npz",
        notes="section",
        counts="orbits",
        prints_rows=True,
    ),
    Verb(
        *("map", "polhode.dynamics.chaos_map", "chaos_map", "ChaosMap"),
        "a chaos map: growth of one tangent per motion, over a grid or two varied numbers",
        "general/asymmetric-regular --grid 2x2 --end 20 -o map.npz",
        notes="chaos_map",
        figure_options={"--what": _figure_word(_MAP), "--cmap": _CMAP, **_TITLE},
        counts="motions",
    ),
    Verb(
        *("orbit", "polhode.dynamics.orbit", "orbit", "Orbit"),
        "the periodic orbit near a start to up to 300 digits, and its stability",
        "grioli/precession --digits 20",
        notes="orbit",
        own=(".toml",),
    ),
    Verb(
        *("orbits", _FUNCTIONS, "orbits", "OrbitSearch"),
        "the periodic orbits of a level, searched from cells of its section, or one of them",
        "general/asymmetric-regular --grid 4x4 --crossings 1 -o orbits.csv",
        notes="orbits",
        other_kinds={"pick": "orbit"},
        prints_rows=True,
    ),
    Verb(
        *("family", "polhode.dynamics.families", "orbit_family", "OrbitFamily"),
        "a family of periodic orbits along the energy or the vertical momentum",
        "grioli/precession --by h --to 0.84 -o family.json",
        notes="itself",
        prints_rows=True,
    ),
    Verb(
        *("prove orbit", f"{_PROOFS}.proved_orbit", "prove_orbit", "ProvedOrbit"),
        "that a periodic orbit exists, where, how stable it is",
        "grioli/precession -o orbit.json",
        notes="proved_orbit",
        own=(".json",),
    ),
    Verb(
        *("prove orbits", f"{_PROOFS}.proved_orbit", "prove_orbits", "ProvedOrbits"),
        "which orbits of a search of a level exist",
        "general/asymmetric-regular --grid 4x4 --crossings 1",
        notes="orbits",
        figure_options=None,
    ),
    Verb(
        *("prove stability", f"{_PROOFS}.proved_stability", "prove_stability", "ProvedStability"),
        "that a periodic orbit is stable for all time",
        "general/asymmetric-regular -o stability.json",
        notes="proved_orbit",
        own=(".json",),
    ),
    Verb(
        *("prove chaos", f"{_PROOFS}.proved_chaos", "prove_chaos", "ProvedChaos"),
        "that the motion on a level is chaotic",
        "general/asymmetric-chaotic -o chaos.json",
        notes="proved_chaos",
        own=(".json",),
    ),
    Verb(
        *("verify", "polhode.certificates.verdict", "verify", "Verdict"),
        "check a proof's certificate, by a program of its own",
        "state.json",
        figure_options=None,
    ),
    Verb(
        *("frequencies", "polhode.dynamics.frequencies", "frequencies", "Frequencies"),
        "frequency analysis (Laskar) of a motion, from a scene or a trajectory file",
        "lagrange/nutation --of gamma3 --end 50",
        notes="frequencies",
        prints_rows=True,
    ),
    Verb(
        *("report", "polhode.output.report", "report", "Report"),
        "an accuracy report of your scenes, and of files that other programs made of their motions",
        "top.toml top.csv -o report.html",
        named={"at": None},
        scene=(TIMES,),
        own=(".html", ".md"),
        figure_options=None,
    ),
    Verb(
        *("guide", "polhode.verbs.guide", "guide", ""),
        "the guide: topics, one of them, or where a word occurs",
        "judging",
    ),
    Verb(
        *("about", "polhode.output.about", "about", "About"),
        "versions, number types, processor, caches; how to cite",
        "--cite",
        figure_options=None,
    ),
)

VERBS = {verb.name: verb for verb in ROWS}

#: First words of the verbs, as they are listed.
NAMES = tuple(dict.fromkeys(verb.name.partition(" ")[0] for verb in ROWS))

#: Verbs of several words by the first one, and what that is about.
GROUPS = {
    "prove": "proofs: periodic orbits, where they are, which are stable; that a level is chaotic"
}
