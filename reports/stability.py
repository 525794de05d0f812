"""Study ``stability``: the hard cases in every number type, and the way back from their ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from textwrap import fill
from typing import Any

import kit
import polhode
from accuracy import case_rows
from kit import expected
from polhode.equations.readout import Readout
from polhode.numbers.conversion import ExactNumbers, number_value
from polhode.taylor.motion import Motion
from polhode.taylor.system import system

QUESTION = (
    "How many of the digits that a hard motion allows are left in each number type, and why not "
    "more? How far from its start does a run end that goes there and back?"
)
#: The number types of the way back, and the most radians one way.
LONGEST = {"double": 1e4, "extended": 1e4, "quad": 200.0}
SPARE_DIGITS = 40  # of the states from which kappa of the way back is computed
QUARTERS = 4  # of the way, each of whose ends is one of those states


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    chosen = [name for name in hard_names(quick) if only(name)]

    def tell(scene: polhode.Scene) -> None:
        say(f"{scene.name}, {chosen.index(scene.name) + 1} of {len(chosen)}")

    workers = 1 if quick else kit.cores()
    scenes = [polhode.load(name) for name in chosen]
    pairs = zip(scenes, case_rows(scenes, workers, tell), strict=True)
    cases = [_hard(scene, row) for scene, row in pairs]
    longest_first = sorted(scenes, key=lambda scene: -scene.log10_angle)
    ways_back = dict(
        zip(
            (s.name for s in longest_first),
            kit.in_order(_back, longest_first, workers, tell),
            strict=True,
        )
    )
    return {
        "kinds": [
            {"kind": kind, "cases": [name for name in names if name in chosen]}
            for kind, names in KINDS.items()
        ],
        "cases": cases,
        "back": [row for name in chosen for row in ways_back[name]],
    }


def _hard(scene: polhode.Scene, row: dict[str, Any]) -> dict[str, Any]:
    """A case of the study of accuracy, with how far each run is behind what was expected."""
    return row | {"end": float(scene.end), "runs": [_judged(run) for run in row["runs"]]}


def _judged(run: dict[str, Any]) -> dict[str, Any]:
    if "correct_digits" not in run:
        return run
    expected = run["expected"]
    behind = None if expected is None else round(expected[0] - run["correct_digits"], 2)
    return run | {"behind": behind, "lost": run["lost"] or ""}


def _back(scene: polhode.Scene) -> list[dict[str, Any]]:
    """Errors of a run to the end and back to 0, beside what kappa of either way allows."""
    angle = 10**scene.log10_angle
    numbers = [name for name, longest in LONGEST.items() if angle <= longest]
    if not numbers:
        return []
    there = polhode.conditioning(scene, number="quad").log10_kappa[-1]
    times = [scene.end * Fraction(k, QUARTERS) for k in range(1, QUARTERS + 1)]
    ways = [
        way_back(scene, t, state)
        for t, state in zip(times, polhode.reference(scene).at(times, SPARE_DIGITS), strict=True)
    ]
    backs = [polhode.conditioning(home, number="quad").log10_kappa[-1] for home in ways]
    back = max((x for x in backs if x is not None), default=None)
    kappa = None if there is None or back is None else max(there, back)
    rows = []
    for name in numbers:
        eps = error(scene, kit.TYPES[name])
        rows.append(
            {
                "case": scene.name,
                "number": name,
                "log10_kappa": None if there is None else round(there, 2),
                "log10_kappa_back": None if back is None else round(back, 2),
                "error_eps": kit.significant(eps, 3),
                "times_kappa": None if kappa is None else kit.significant(eps / 10**kappa, 2),
                "within": None if kappa is None else eps <= 10**kappa,
            }
        )
    return rows


# --- hard cases -----------------------------------------------------------------------------------
#
# The hard cases by what is hard about them: names of cases that ship.


#: The cases of each difficulty.
KINDS = {
    kind: tuple(names.split())
    for kind, names in {
        "Flips from next to the middle axis": """
            hard/dzhanibekov-1e-3 euler/dzhanibekov hard/dzhanibekov-1e-9 hard/dzhanibekov-1e-12
        """,
        "Exact separatrices": """
            euler/separatrix euler/separatrix-backward euler/separatrix-irrational
            lagrange/homoclinic lagrange/planar-separatrix pendulum/separatrix
        """,
        "Next to a separatrix": """
            euler/near-separatrix hard/near-homoclinic hard/complementary-modulus-1e-40
        """,
        "Nearly equal moments": "euler/nearly-symmetric hard/nearly-symmetric-heavy",
        "Spin about its critical value": """
            lagrange/sleeping-critical hard/sleeping-above-critical-spin
            hard/sleeping-below-critical-spin hard/tilted-critical-spin
            hard/tilted-above-critical-spin hard/tilted-below-critical-spin hard/near-steady
        """,
        "Cusps": "lagrange/cusped hard/near-cusp",
        "Next to a solvable case": """
            hard/near-bobylev-steklov-asymmetric hard/near-chaplygin hard/near-goryachev-chaplygin
            hard/near-goryachev hard/near-grioli hard/near-hess hard/near-n-kowalewski
            hard/near-staude hard/near-steklov
        """,
        "Through a pole or past it": """
            lagrange/upper-pole lagrange/lower-pole lagrange/from-the-pole hard/near-pole
            published/bruels-cardona-arnold
        """,
        "Next to degenerate motions of the Kovalevskaya top": """
            kovalevskaya/near-delaunay hard/near-appelrot hard/near-bobylev-steklov
            hard/near-asymptotic hard/near-quasi-periodic hard/near-multiply-degenerate
            hard/near-axial-pendulum hard/near-equatorial-pendulum
        """,
        "Fast spin": "euler/fast-spin hard/fast-top hard/very-fast-top",
        "Units that make the numbers huge or tiny": """
            euler/huge-units euler/tiny-units hard/heavy-huge-units hard/heavy-tiny-units
        """,
        "Needle and flat body": "euler/needle euler/flat",
        "Unstable equilibria and permanent rotations": """
            euler/permanent-middle euler/turned-permanent lagrange/sleeping-unstable
            pendulum/upright hard/staude
        """,
        "Chaotic and falling bodies": """
            general/asymmetric-chaotic hard/chaotic-long general/near-upright
        """,
        "A million units of time": "hard/million",
    }.items()
}

QUICK = (
    "euler/dzhanibekov",
    "euler/separatrix",
    "hard/near-homoclinic",
    "hard/near-pole",
    "hard/heavy-tiny-units",
    "hard/sleeping-below-critical-spin",
)


def hard_names(quick: bool = False) -> list[str]:
    """All hard cases, or the few of a quick study."""
    return [name for cases in KINDS.values() for name in cases if not quick or name in QUICK]


# --- there and back -------------------------------------------------------------------------------
#
# A run to a scene's end and back to its start, and the motion from its end back.


def error(scene: polhode.Scene, number: polhode.NumberType) -> float:
    """The error of the state, in eps, of a run to the scene's end and back to 0.

    Relative as in *correct digits*, to |w| at 0; against the start as the type rounds it.
    """
    plain = replace(scene, outputs=(), events=())
    equations = system(plain, number=number)
    motion = Motion(equations)
    motion.begin(equations)
    unit = equations.frame.unit
    row: Any = None
    for t in (number.rounded(number.rounded(scene.end) / unit), Fraction(0)):
        row = motion.advance(ExactNumbers((t,)), 10**8)[0][0]
    rounded = [number.rounded(x) for x in equations.start]
    read = Readout(plain, number)
    back = read.states([row])[0]
    start = read.states([[number_value(x, number) for x in rounded]])[0]
    (apart,) = polhode.state_errors([back], [start], plain)
    return float(apart / number.eps)


def way_back(scene: polhode.Scene, t: Any, state: Sequence[Any]) -> polhode.Scene:
    """The motion from the scene's state at time t back to 0; ``state``: p q r [gamma], as mpf.

    gamma is brought to length 1.
    """
    p, q, r, *gamma = map(kit.exactly, state)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma or None, "normalise": True}
    return replace(scene, **start, times=(-t,), outputs=(), events=())


# --- page -----------------------------------------------------------------------------------------
#
# Tables and facts of the stability study's page.


_AGAIN = "python reports/make.py stability --only {0}"


def _pair(run: kit.JsonObject | None) -> float | str | None:
    """The digits of a run and those expected; in words where it has none."""
    right = kit.digits(run)
    if run is None or right is None or isinstance(right, str):
        return right
    return f"{right:.1f} / {kit.formatted(run['band'], '')}"


_KAPPA = kit.Column(
    "log10 kappa",
    "log10_kappa",
    ".1f",
    "the decimal logarithm of kappa, the most that the state at the end changes per unit of "
    "relative change of all inputs at once (a dash: not computed)",
)
_CASES = (
    kit.CASE,
    kit.Column("difficulty", "kind"),
    *kit.ABOUT[1:],
    _KAPPA,
    *kit.in_numbers(
        _pair,
        "correct digits at the worst output time / where nine in ten runs would end there that "
        "round the state once a step (see [accuracy](accuracy.md)), in that number type (a dash: "
        "not run, it would take too long)",
    ),
)
_BEHIND = (
    kit.CASE,
    kit.NUMBER,
    kit.Column("correct", "correct_digits", ".1f", "correct digits at the worst output time"),
    kit.Column(
        "expected",
        lambda run: expected(run["expected"]),
        ">",
        "where nine in ten such runs would end",
    ),
    kit.Column("behind", "behind", ".1f", "the least digits expected less those correct"),
    kit.Column(
        "inputs", "inputs", ".1f", "correct digits of the exact motion of the rounded inputs"
    ),
    kit.STEPS,
    kit.Column("limited by", "limit"),
)
_BACK = (
    kit.CASE,
    _KAPPA,
    kit.Column(
        "back",
        "log10_kappa_back",
        ".1f",
        "the largest on the way back, from the end and three times before",
    ),
    *(
        kit.Column(
            *(f"{name}, eps", f"runs.{name}.error_eps", ".2g"),
            "the error of the state at 0 against the rounded start, in eps of the number type",
        )
        for name in kit.NUMBERS[:3]
    ),
    kit.Column("within kappa·eps", lambda case: _within(case["runs"])),
)
_UNJUDGED = (
    kit.CASE,
    kit.NUMBER,
    kit.Column("why", lambda run: run.get("limit") or run["outcome"]),
    kit.Column("kappa", "kappa_note", "", "why the digits expected are not known"),
)


def tables(results: kit.JsonObject) -> dict[str, kit.PageTable]:
    """The page's tables from the study's JSON object."""
    cases = {case["case"]: kit.by_number(case) for case in results["cases"]}
    hard = [
        {**cases[name], "kind": kind["kind"]} for kind in results["kinds"] for name in kind["cases"]
    ]
    runs = [{**case, **run} for case, run in kit.runs_of(results["cases"])]
    late = [run for run in runs if (run.get("behind") or 0) > 0]
    ways: dict[str, kit.JsonObject] = {}
    for row in results["back"]:
        ways.setdefault(row["case"], {**row, "runs": {}})["runs"][row["number"]] = row
    return {
        "cases": kit.table(hard, _CASES, _AGAIN),
        "behind": kit.table(sorted(late, key=lambda run: -float(run["behind"])), _BEHIND, _AGAIN),
        "unjudged": kit.table([r for r in runs if r.get("behind") is None], _UNJUDGED, _AGAIN),
        "back": kit.table(ways.values(), _BACK, _AGAIN),
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    behind = [run.get("behind") for _, run in kit.runs_of(results["cases"])]
    judged = [row for row in results["back"] if row["within"] is not None]
    return {
        "enough": kit.share(x <= 0 for x in behind if x is not None),
        "motions": len(results["cases"]),
        "within": kit.share(row["within"] for row in judged),
        "times_kappa": max((row["times_kappa"] for row in judged), default=0),
    }


def _within(runs: kit.JsonObject) -> str:
    """Of each number type, whether its run came back within kappa·eps."""
    said = {True: "yes", False: "no", None: "not known"}
    return ", ".join(f"{name}: {said[row['within']]}" for name, row in runs.items())


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the stability study: correct digits of the hard cases, a strip a difficulty.


_WIDTH = 24  # letters of a line of a strip's name


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """One strip per kind of difficulty; rings have fewer digits than expected."""
    runs = {case["case"]: case["runs"] for case in results["cases"]}
    groups = {
        fill(kind["kind"], _WIDTH): [
            run for name in kind["cases"] for run in runs.get(name, ()) if "correct_digits" in run
        ]
        for kind in results["kinds"]
    }
    return {"stability": kit.strips({kind: dots for kind, dots in groups.items() if dots})}
