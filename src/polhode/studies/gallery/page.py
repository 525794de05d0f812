"""Page of the gallery."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.gallery.figure import name
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.case_runs import REFERENCES
from polhode.studies.page.words import sentence

TITLE = "Gallery: motions worth knowing"


def blocks(found: JsonObject) -> Iterator[Block]:
    """A picture, a sentence, the scene and a command for each motion."""
    yield Text(
        "Each picture shows the path of a point of the body on a sphere about the fixed point, Z "
        "upwards. It starts at the dot, at t = 0; what lies behind is lighter. The paths are runs "
        "in double, and the correct digits at their end are given."
    )
    for row in found["motions"]:
        case = row["case"]
        yield Heading(row["name"])
        yield Text(f"{sentence(row['seen'])}.")
        yield Text(
            f"The {row['point']} to t = {row['end']}; {row['regime']}. {row['digits']:.1f} correct "
            f"digits, judged by {REFERENCES[row['reference']]}. Scene: "
            f"[{case}](../cases/{case}.toml). As a page that moves: `polhode view {case} --end "
            f"{row['end']} -o motion.html`."
        )
        yield Figure(name(row), f"{row['name']}: the {row['point']} in space")


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    return (
        f"{len(found['motions'])} motions, from the wavy precession to chaos, each with its scene."
    )
