"""What the page of all studies begins with: what polhode is, a top that moves, three numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from html import escape

from polhode.runs.trajectory import Trajectory
from polhode.studies.page.blocks import Number

#: What it is, in a sentence.
WHAT = (
    "polhode computes how a heavy rigid body moves about a fixed point: the tops of Euler, "
    "Lagrange and Kovalevskaya, and any other. It says how many digits are right, and can prove it."
)
_SIZE, _RADIUS = 240.0, 100.0  # of the drawing, and of the sphere on which the axis moves
_TILT = math.radians(20)  # of the view, from above the horizon
_PER_SECOND = 24  # samples that are shown in a second


def hero(run: Trajectory, numbers: Sequence[Number]) -> Iterator[str]:
    """Lines of HTML; ``run``: a motion with its angles, whose end leads to its beginning."""
    yield '<div class="hero"><div>'
    yield f"<p>{escape(WHAT)}</p>"
    if numbers:
        yield '<ul class="numbers">'
        yield from (f"<li><b>{escape(x)}</b>{escape(words)}</li>" for x, words in numbers)
        yield "</ul>"
    yield "</div>"
    yield moving(run)
    yield "</div>"


def moving(run: Trajectory) -> str:
    """A drawing that moves without a script: the third axis, and the path of its end."""
    points = [
        _seen(float(psi), float(theta)) for psi, theta in zip(run.psi, run.theta, strict=True)
    ]
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
    columns = [";".join(f"{place[k]:.1f}" for place in points) for k in (0, 1)]
    seconds = len(points) / _PER_SECOND
    middle, (x, y) = _SIZE / 2, points[0]

    def moved(name: str, values: str) -> str:
        return (
            f'<animate attributeName="{name}" values="{values}" dur="{seconds:.1f}s" '
            'repeatCount="indefinite"/>'
        )

    return (
        f'<svg viewBox="0 0 {_SIZE:g} {_SIZE:g}" role="img" '
        f'aria-label="The axis of {escape(run.scene.title)}, moving">'
        f'<circle cx="{middle:g}" cy="{middle:g}" r="{_RADIUS:g}" fill="#f4f8fb" '
        'stroke="#b9c9d6"/>'
        f'<path d="{path}" fill="none" stroke="#0072b2" stroke-opacity=".45"/>'
        f'<line x1="{middle:g}" y1="{middle:g}" x2="{x:.1f}" y2="{y:.1f}" stroke="#1b1b1b" '
        f'stroke-width="4" stroke-linecap="round">{moved("x2", columns[0])}'
        f"{moved('y2', columns[1])}</line>"
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="#d55e00">{moved("cx", columns[0])}'
        f"{moved('cy', columns[1])}</circle></svg>"
    )


def _seen(psi: float, theta: float) -> tuple[float, float]:
    """Where the end of the axis is on the drawing, seen from a little above."""
    x, y = math.sin(theta) * math.sin(psi), -math.sin(theta) * math.cos(psi)
    up = math.cos(_TILT) * math.cos(theta) + math.sin(_TILT) * y
    return _SIZE / 2 + _RADIUS * x, _SIZE / 2 - _RADIUS * up
