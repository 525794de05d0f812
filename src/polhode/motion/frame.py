"""Between a scene's axes and unit of time, and those in which its motion is computed.

A motion is computed along axes that suit the equations, the principal ones but for some forms, and
in a unit of time in which its rates are near 1.  The change is exact: inside, the motion is that of
another scene, whose own frame changes nothing.  So what computes knows nothing of axes and units;
those know them who take a scene from a user, or hand rows back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, TypeVar

from polhode.numbers import exact
from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import Flat, NumberType
from polhode.numbers.vectors import Matrix, Vector, apply, cross, dot, is_zero, scaled
from polhode.scenes.body import IDENTITY, OWN_AXES, Body, PrincipalAxes, diagonal
from polhode.scenes.scene import Scene

T = TypeVar("T", Scene, Body)
Time = TypeVar("Time", Fraction, Exact)
_PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))


class Frame(NamedTuple):
    """The axes along which a motion is computed, in those of its scene, and its unit of time.

    ``exponent``: the unit of time inside is 2**exponent of the scene's.

    Of a body that spins with about 1000 radians a second, in axes turned by a right angle:

    >>> from fractions import Fraction
    >>> import polhode
    >>> from polhode.motion.frame import Frame
    >>> body = polhode.Body([[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 1]], [0, 0, 1], "9.8")
    >>> scene = polhode.Scene(body, omega=(0, 0, 1000), gamma=("3/5", 0, "4/5"))
    >>> frame = Frame.of(scene)
    >>> inside = frame.inside(scene)
    >>> frame.exponent, [float(x) for x in inside.omega], inside.body.moments == body.moments
    (-10, [0.9765625, 0.0, 0.0], True)
    >>> frame.time(Fraction(1)), Frame.of(inside).trivial
    (Fraction(1024, 1), True)
    """

    axes: PrincipalAxes = OWN_AXES
    exponent: int = 0

    @classmethod
    def of(cls, scene: Scene, axes: PrincipalAxes | None = None) -> Frame:
        """The frame of a scene: along these axes, the principal ones where none are given."""
        return cls(scene.body.axes if axes is None else axes, scene.time_unit)

    def slower(self, by: int) -> Frame:
        """The same axes, and a unit of time that is 2**by as long."""
        return Frame(self.axes, self.exponent + by)

    @property
    def trivial(self) -> bool:
        """Whether the motion is computed in the scene's own axes and unit of time."""
        return not self.exponent and self.axes.trivial

    @property
    def unit(self) -> Fraction:
        """The unit of time inside, in the scene's."""
        return _power_of_two(self.exponent)

    def time(self, t: Time) -> Time:
        """A time of the scene's as it is inside."""
        return t / self.unit if self.exponent else t

    def time_outside(self, t: Time) -> Time:
        """A time inside as it is in the scene's unit."""
        return t * self.unit if self.exponent else t

    @property
    def turn(self) -> dict[str, Exact]:
        """The non-zero entries of the turn to the scene's axes by name; none where it is none."""
        if self.axes.trivial:
            return {}
        named = {f"turn{i}{j}": self.axes.rows[i][j] for i in range(3) for j in range(3)}
        return {name: x for name, x in named.items() if sign(x) != 0}

    def matrix(self, number_type: NumberType) -> Flat:
        """Its axes along the scene's, a row each, as doubles or longdoubles.

        A row of components inside, times it, is along the scene's axes.
        """
        import numpy as np

        nearest = to_double if number_type.name == "double" else to_extended
        return np.array([[nearest(x) for x in row] for row in self.axes.rows])

    def inside(self, scene: Scene) -> Scene:
        """The same motion as a scene in this frame, exactly: no outputs, events or times."""
        if self.trivial:
            return scene
        unit, components = self.unit, self.axes.components
        changes = {
            "body": self._body(scene.body, unit * unit),
            "omega": components(scaled(unit, scene.omega)),
            "_source": "",
            **_OUTSIDE,
        }
        if scene.gamma is not None and not self.axes.trivial:
            changes["gamma"] = components(scene.gamma)
            changes["psi"] = scene.psi + self._psi(scene.gamma)
        return _changed(scene, changes)

    def _body(self, body: Body, square: Fraction) -> Body:
        """The body in this frame; ``square``: of the unit of time."""
        axes, inertia, own = self.axes, body.inertia, body.axes
        if not axes.trivial and axes is own:
            inertia, own = diagonal(body.moments), OWN_AXES
        elif not axes.trivial:
            inertia = along(axes, inertia)
            x, y, z = map(axes.components, own.directions)
            own = PrincipalAxes((x, y, z), own.squares)
        return _changed(
            body,
            {
                "inertia": inertia,
                "centre": axes.components(body.centre),
                "weight": body.weight * square,
                "parts": (),
                "axes": own,
            },
        )

    def _psi(self, gamma: Vector) -> Exact:
        """By how much psi of these axes is ahead of that of the scene's.

        psi is told by the line of nodes, gamma × the third axis; at a pole by the first axis.
        """
        nodes, own = (
            first if is_zero(line := cross(gamma, third)) else line
            for first, _, third in (IDENTITY, self.axes.directions)
        )
        return exact.arctan2(dot(cross(nodes, own), gamma), dot(nodes, own))


@lru_cache(1024)
def _power_of_two(exponent: int) -> Fraction:
    return Fraction(2) ** exponent


#: The frame of a scene inside one.
NO_CHANGE = Frame()


def along(axes: PrincipalAxes, matrix: Matrix) -> Matrix:
    """A symmetric matrix, given in a scene's axes, along these axes."""
    images = [apply(matrix, u) for u in axes.directions]
    entry = {}
    for i, j in _PAIRS:
        size = exact.sqrt(axes.squares[i] * axes.squares[j]) if i != j else axes.squares[i]
        x = dot(axes.directions[i], images[j])
        entry[i, j] = entry[j, i] = ZERO if sign(x) == 0 else x / size
    a, b, c = ((entry[i, 0], entry[i, 1], entry[i, 2]) for i in range(3))
    return a, b, c


#: What a scene's place in the world is, which is of no use inside.
_OUTSIDE = dict.fromkeys(("times", "tags", "cite", "outputs", "events", "published"), ())
_FIELDS = {kind: tuple(field.name for field in fields(kind)) for kind in (Scene, Body)}


def _changed(thing: T, changes: Mapping[str, object]) -> T:
    """A scene or a body with other fields, not checked again: what is exact stays possible."""
    copy = object.__new__(type(thing))
    values = vars(thing)
    vars(copy).update({name: values[name] for name in _FIELDS[type(thing)] if name in values})
    vars(copy).update(changes)
    return copy
