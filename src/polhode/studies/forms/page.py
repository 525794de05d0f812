"""Page of the study of the forms."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.case_runs import REFERENCES
from polhode.studies.page.columns import NUMBER, STEPS, Column, table
from polhode.studies.page.words import DASH, between, listed, share

TITLE = "Forms: which form of the equations to use"

_TAKE = {
    "general": "a body given by its inertia matrix, where its own axes are to be kept",
    "inertia-axes": "formulas in the source's special axes; nothing is gained in a run",
    "principal": "by default",
    "momentum": "questions about G; as cheap as principal in principal axes",
    "gyration-axes": "formulas in Kharlamov's axes; nothing is gained in a run",
    "lagrangian": "comparison with codes in angles, away from the poles",
    "hamiltonian": "canonical variables, away from the poles",
    "routhian": "angles with the fewest variables, away from the poles",
    "omega-only": "a motion known through omega alone, with a weight",
    "momentum-only": "a motion known through G alone, with a weight",
    "quaternion": "attitude wanted all along; its norm is held",
}

_SHOWN = (
    "Correct digits and time of every form for every motion. No mark: the form refuses the motion "
    "or ends at its singular set."
)


_ADVICE = (
    Column("form", "form"),
    Column("source", "source", "", "equations of the source, see `polhode guide forms`"),
    Column("motions", "share", meaning="runs in double that reach the end, of all"),
    Column("time / principal", "times", ">", "their time over that of the principal form"),
    Column("most digits lost", "lost", ".1f", "digits less than in the principal form, at most"),
    Column("other outcomes", "else", "", "how the other runs ended"),
    Column("use it for", lambda row: _TAKE[row["form"]]),
)
_RUNS = (
    Column("form", "form"),
    NUMBER,
    STEPS,
    Column("run, ms", lambda run: _milliseconds(run, "run"), ".2f", "the least of several"),
    Column("build, ms", lambda run: _milliseconds(run, "build"), ".0f", "making the integrator"),
    Column(
        "time / principal", "time_against_principal", ".2f", "time over that of the principal form"
    ),
    Column("digits", "correct_digits", ".1f", "correct digits, the fewest of ten times"),
    Column("lost", "lost_digits", ".1f", "digits of the principal form less those of this form"),
    Column("outcome", lambda run: ": ".join(run[k] for k in ("outcome", "reason") if k in run)),
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Correct digits are judged by the reference of each case. A form in angles ends where sin "
        "theta falls below about eps^(1/4), the forms in omega or G alone where Iw is equally "
        "near to the direction of r0. A passage at a distance d from such a singular set costs "
        "about log10(1/d) digits; a result that is given has therefore lost at most about a "
        "quarter of the type's digits to it. Angles that are variables grow without bounds, and "
        "heyoka's steps are only as accurate as the largest variable asks: the longer a form in "
        "angles runs, the fewer and the less accurate its steps."
    )
    yield Figure("forms", _SHOWN)
    yield Heading("Which form to use")
    yield table(_advice(found), _ADVICE, "polhode study forms -o DIR")
    for motion in found["motions"]:
        yield Heading(f"{motion['what']}: `{motion['case']}`")
        axes = f" Axes in the order {motion['axes']}." if motion["axes"] else ""
        told = (
            f"To t = {motion['end']} (in quad to a tenth of that), judged by "
            f"{REFERENCES[motion['reference']]}."
        )
        yield Text(told + axes)
        yield table(motion["runs"], _RUNS, f"polhode study forms --only {motion['case']}")


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    runs = [r for r in _in_double(found) if r["form"] != "principal"]
    done = [r for r in runs if "correct_digits" in r]
    if not done:
        return ""
    slowest = max(done, key=lambda r: r["time_against_principal"])
    worst = max(done, key=lambda r: r["lost_digits"])
    ahead = sum(r["lost_digits"] < 0 for r in done)
    faster = share(r["time_against_principal"] < 1 for r in done)
    return (
        f"In double the other forms take up to {slowest['time_against_principal']:.1f} times as "
        f"long as the principal form ({slowest['form']}) and have up to {worst['lost_digits']:.1f} "
        f"correct digits fewer ({worst['form']}); {faster} runs in them are faster, {ahead} have "
        "more correct digits."
    )


def _in_double(found: JsonObject) -> list[JsonObject]:
    return [r for m in found["motions"] for r in m["runs"] if r["number"] == "double"]


def _milliseconds(run: JsonObject, part: str) -> float | None:
    return 1e3 * run["seconds"][part] if "seconds" in run else None


def _advice(found: JsonObject) -> Iterator[JsonObject]:
    """A row for each form, of its runs in double."""
    for form, place in found["sources"].items():
        runs = [r for r in _in_double(found) if r["form"] == form]
        done = [r for r in runs if "correct_digits" in r]
        yield {
            "form": form,
            "source": place,
            "share": share("correct_digits" in r for r in runs),
            "times": between([r["time_against_principal"] for r in done], ".1f", DASH),
            "lost": max((r["lost_digits"] for r in done), default=None),
            "else": listed(r["outcome"] for r in runs if "correct_digits" not in r),
        }
