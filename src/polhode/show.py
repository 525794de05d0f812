"""What a scene is: body, regime, integrals, frequencies, and what a run of it will model."""

from __future__ import annotations

from typing import Any

from polhode import answers
from polhode.forms import principal
from polhode.precision import shown
from polhode.references.kinds import kind_of_body
from polhode.scene import Scene
from polhode.truth import reference


def described(scene: Scene) -> dict[str, Any]:
    """The facts that ``polhode show`` prints, as a JSON object."""
    truth = reference(scene)
    body = scene.body
    values = scene.integrals
    coefficients = principal.coefficients(body)
    facts: dict[str, Any] = {
        "scene": scene.name,
        "title": scene.title,
        "tags": list(scene.tags),
        "cite": list(scene.cite),
        "body": kind_of_body(body),
        "regime": truth.regime,
        "reference": truth.kind,
        "moments": [shown(x) for x in body.moments],
        "torque": [shown(x) for x in body.torque],
    }
    if not body.axes.trivial:
        facts["axes"] = [[shown(x) for x in row] for row in body.axes.rows]
    facts["integrals"] = {"h": shown(values.energy)}
    if values.area is not None:
        facts["integrals"] |= {"f": shown(values.area)}
    if truth.is_closed_form:
        facts["frequencies"] = answers.frequencies(truth)
    facts |= {
        "form": scene.form,
        "columns": answers.columns_of(scene),
        "coefficients": sorted(coefficients),
        "times": len(scene.times),
        "end": shown(scene.end),
        "time_unit": f"2**{scene.time_unit}",
    }
    return facts
