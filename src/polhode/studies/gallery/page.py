"""Page of the gallery."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.gallery.figure import name
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.words import sentence

TITLE = "Gallery: motions worth knowing"


def blocks(found: JsonObject) -> Iterator[Block]:
    """A picture, a sentence, the scene and a command for each motion."""
    yield Text(
        "Each picture follows a point of the body on a sphere about the fixed point, Z upwards, "
        "from the dot at t = 0 on; what lies behind is lighter. The paths are runs in double; "
        "beside each stand the digits that are right at its end."
    )
    for row in found["motions"]:
        case = row["case"]
        yield Heading(row["name"])
        yield Figure(name(row), f"{row['name']}: the {row['point']} in space")
        yield Text(f"{sentence(row['seen'])}.")
        yield Text(
            f"The {row['point']} to t = {row['end']}; {row['regime']}, {row['digits']:.1f} digits "
            f"right by {row['reference']}. Scene: [{case}](../cases/{case}.toml). "
            f"In motion: `polhode view {case} --end {row['end']} -o motion.html`."
        )


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    return (
        f"{len(found['motions'])} motions, from the wavy precession to chaos, each with its scene"
    )
