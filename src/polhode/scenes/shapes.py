"""Bodies by shape: exact moments of inertia of homogeneous solids, and of bodies put together.

Moments about a solid's own centre of mass are those of any textbook (Landau and Lifshitz,
*Mechanics*, section 32, problem 2); to the fixed point they are carried by Huygens and Steiner's
theorem, I = I_c + m (|c|² 1 - c cᵀ).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.arguments import each, of_kind
from polhode.common.errors import BadInput, nearest
from polhode.numbers.conversion import reader
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.expression import in_units
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.numbers.vectors import Matrix, Vector

AXES = ("z", "x", "y", "-z", "-x", "-y")
_LENGTHS = ("size", "semi_axes", "radius", "height", "inner")
_VECTORS = ("size", "semi_axes", "at")
_MAY_VANISH = ("height", "inner")


class SolidShape(NamedTuple):
    """How a solid of mass 1 is described: its lengths, moments about its centre, where that is.

    ``needs`` and ``takes``: names of its lengths, the second may be left out.  ``moments``: about
    its centre of mass, the third about its axis.  ``lift``: of its centre of mass above the point
    ``at``, along the axis.  ``round``: whether it has an axis that may be chosen.
    """

    needs: tuple[str, ...]
    takes: tuple[str, ...]
    moments: Callable[[Mapping[str, Any]], Vector]
    round: bool = True
    lift: Callable[[Mapping[str, Any]], Exact] = lambda _: ZERO


def _of_squares(lengths: Vector, part: int) -> Vector:
    a, b, c = (x * x for x in lengths)
    return (b + c) / part, (c + a) / part, (a + b) / part


def _cylinder(k: Mapping[str, Any]) -> Vector:
    square = k["radius"] * k["radius"] + k["inner"] * k["inner"]
    across = (3 * square + k["height"] * k["height"]) / 12
    return across, across, square / 2


def _cone(k: Mapping[str, Any]) -> Vector:
    radius, height = k["radius"] * k["radius"], k["height"] * k["height"]
    across = 3 * (4 * radius + height) / 80
    return across, across, 3 * radius / 10


def _ball(k: Mapping[str, Any]) -> Vector:
    """2 (R⁵ - r⁵) / 5 (R³ - r³), divided through by R - r: a thin shell is one, too."""
    a, b = k["radius"], k["inner"]
    four = a * a * a * a + a * a * a * b + a * a * b * b + a * b * b * b + b * b * b * b
    moment = 2 * four / (5 * (a * a + a * b + b * b))
    return moment, moment, moment


def _rod(k: Mapping[str, Any]) -> Vector:
    return k["height"] * k["height"] / 12, k["height"] * k["height"] / 12, ZERO


#: The solids by name.
SHAPES: dict[str, SolidShape] = {
    "box": SolidShape(("size",), (), lambda k: _of_squares(k["size"], 12), round=False),
    "cylinder": SolidShape(("radius", "height"), ("inner",), _cylinder),
    "disc": SolidShape(("radius",), ("inner",), _cylinder),
    "cone": SolidShape(("radius", "height"), (), _cone, lift=lambda k: 3 * k["height"] / 4),
    "ellipsoid": SolidShape(
        ("semi_axes",), (), lambda k: _of_squares(k["semi_axes"], 5), round=False
    ),
    "sphere": SolidShape(("radius",), ("inner",), _ball, round=False),
    "rod": SolidShape(("height",), (), _rod),
    "point": SolidShape((), (), lambda _: (ZERO, ZERO, ZERO), round=False),
}


@dataclass(frozen=True)
class Part:
    """A homogeneous solid, part of a body: its shape, mass, lengths, and where it is.

    ``shape``: box (``size``), cylinder (``radius``, ``height``, ``inner``), disc (``radius``,
    ``inner``), cone (``radius``, ``height``), ellipsoid (``semi_axes``), sphere (``radius``,
    ``inner``), rod (``height``), point.  ``at``: its centre (for a cone its tip) from the fixed
    point, in body axes.  ``axis``: for a round part, the body axis along which it lies, and along
    which a cone opens.  Any consistent units; numbers of any kind are exact, and ``"3 cm"`` is a
    number in SI: ``units`` is then "SI".  Raises BadInput.

    >>> import polhode
    >>> cone = polhode.Part("cone", mass=1, radius=3, height=4)
    >>> cone.centre, cone.inertia[2][2], cone.inertia[0][0]  # about the tip
    ((Fraction(0, 1), Fraction(0, 1), Fraction(3, 1)), Fraction(27, 10), Fraction(219, 20))
    """

    shape: str
    mass: Exact
    size: Vector | None = None
    semi_axes: Vector | None = None
    radius: Exact | None = None
    height: Exact | None = None
    inner: Exact | None = None
    at: Vector = (ZERO, ZERO, ZERO)
    axis: str = "z"
    units: str = field(default="", init=False, repr=False, compare=False)

    if TYPE_CHECKING:  # numbers of any kind are taken, and kept as exact ones

        def __init__(
            self,
            shape: str,
            mass: AnyNumber,
            size: AnyVector | None = None,
            semi_axes: AnyVector | None = None,
            radius: AnyNumber | None = None,
            height: AnyNumber | None = None,
            inner: AnyNumber | None = None,
            at: AnyVector = (0, 0, 0),
            axis: str = "z",
        ) -> None: ...

    def __post_init__(self) -> None:
        of_kind("Part", "shape", self.shape, str, "text")
        if self.shape not in SHAPES:
            raise BadInput("Part", "shape", self.shape, nearest(self.shape, [*SHAPES]))
        shape = SHAPES[self.shape]
        for key in _LENGTHS:
            length = getattr(self, key)
            if length is None and key in shape.needs:
                raise BadInput("Part", key, None, f"a value for shape {self.shape}")
            if length is not None and key not in (*shape.needs, *shape.takes):
                needed = ", ".join((*shape.needs, *shape.takes)) or "no length"
                raise BadInput("Part", key, length, f"nothing: shape {self.shape} has {needed}")
            if length is not None:
                object.__setattr__(self, key, self._exactly(key, length))
            if length is None and key in shape.takes:
                object.__setattr__(self, key, ZERO)
        object.__setattr__(self, "mass", self._exactly("mass", self.mass))
        if sign(self.mass) <= 0:
            raise BadInput("Part", "mass", self.mass, "a mass above 0")
        object.__setattr__(self, "at", self._exactly("at", self.at))
        if self.axis not in AXES:
            raise BadInput("Part", "axis", self.axis, nearest(self.axis, [*AXES]))
        if self.axis != "z" and not shape.round:
            raise BadInput("Part", "axis", self.axis, f"nothing: shape {self.shape} has no axis")
        if self.inner is not None and self.radius is not None and self.inner > self.radius:
            raise BadInput("Part", "inner", self.inner, "a radius no larger than radius")

    def _exactly(self, key: str, value: object) -> Any:
        """A number, or three of them, exactly."""
        several = key in _VECTORS
        numbers = each("Part", key, value if several else (value,), lambda x: x, "numbers")
        if any(isinstance(x, str) and in_units(x) for x in numbers):
            object.__setattr__(self, "units", "SI")
        numbers = each(
            "Part", key, numbers, reader("SI", "kg" if key == "mass" else "m"), "numbers"
        )
        if several and len(numbers) != 3:
            raise BadInput("Part", key, f"{len(numbers)} numbers", "three numbers")
        for x in numbers if key in _LENGTHS else ():
            if sign(x) < 0 or (sign(x) == 0 and key not in _MAY_VANISH):
                raise BadInput("Part", key, x, "a length above 0")
        return numbers if several else numbers[0]

    @property
    def table(self) -> dict[str, object]:
        """Its keys in a scene file; None for a length that it has not."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.init}

    @property
    def lengths(self) -> dict[str, Exact | tuple[Exact, ...]]:
        """Its lengths by name; what may be left out is 0."""
        lengths = {key: getattr(self, key) for key in _LENGTHS if getattr(self, key) is not None}
        return {"height": ZERO, "inner": ZERO} | lengths

    @property
    def direction(self) -> Vector:
        """The unit vector of its axis, in body axes."""
        a, b, c = ((ONE if name == self.axis[-1] else ZERO) for name in "xyz")
        return (-a, -b, -c) if self.axis.startswith("-") else (a, b, c)

    @property
    def centre(self) -> Vector:
        """Its centre of mass, from the fixed point."""
        lift = SHAPES[self.shape].lift(self.lengths)
        a, b, c = (x + lift * e for x, e in zip(self.at, self.direction, strict=True))
        return a, b, c

    @property
    def inertia(self) -> Matrix:
        """Its inertia matrix about the fixed point, in body axes."""
        a, b, c = (self.mass * x for x in SHAPES[self.shape].moments(self.lengths))
        if self.axis[-1] == "x":
            a, c = c, a
        elif self.axis[-1] == "y":
            b, c = c, b
        own: Matrix = ((a, ZERO, ZERO), (ZERO, b, ZERO), (ZERO, ZERO, c))
        return carried(own, self.mass, self.centre)


def carried(inertia: Matrix, mass: Exact, centre: Sequence[Exact]) -> Matrix:
    """An inertia matrix about the centre of mass, carried to the point that ``centre`` is from."""
    x, y, z = centre
    xx, yy, zz = x * x, y * y, z * z
    xy, yz, zx = -(x * y), -(y * z), -(z * x)
    moved = ((yy + zz, xy, zx), (xy, zz + xx, yz), (zx, yz, xx + yy))
    a, b, c = (_row(own, (mass * to for to in by)) for own, by in zip(inertia, moved, strict=True))
    return a, b, c


def together(parts: Sequence[Part]) -> tuple[Exact, Vector, Matrix]:
    """Mass, centre of mass and inertia about the fixed point of parts that turn as one."""
    mass: Exact = ZERO
    moment: Vector = (ZERO, ZERO, ZERO)
    rows: Matrix = (moment, moment, moment)
    for part in parts:
        mass = mass + part.mass
        moment = _row(moment, (part.mass * x for x in part.centre))
        a, b, c = (_row(row, more) for row, more in zip(rows, part.inertia, strict=True))
        rows = (a, b, c)
    x, y, z = (m / mass for m in moment)
    return mass, (x, y, z), rows


def _row(row: Vector, more: Iterable[Exact]) -> Vector:
    a, b, c = (x + y for x, y in zip(row, more, strict=True))
    return a, b, c
