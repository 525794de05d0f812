"""Input that its rounding to doubles alone keeps from being possible, made possible exactly.

An inertia matrix ``R @ D @ R.T`` of numpy is symmetric to some eps, a unit vector of doubles is of
length 1 to as much, and 0.1 + 0.2 is more than what 0.1 and 0.2 add up to.  To 8 eps that is
forgiven, and what was changed is told.  A number that was given as a text is exact: it is not.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import InitVar, dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.arguments import each, numbers_given, of_kind
from polhode.common.errors import BadInput
from polhode.common.values import cached_property
from polhode.numbers import exact, vectors
from polhode.numbers.conversion import derived_number, exact_number
from polhode.numbers.decimals import brief, shown
from polhode.numbers.exact import ONE, ZERO, Exact, Irrational, sign
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.numbers.vectors import Matrix, Vector, apply, cross, dot, is_zero, minus, scaled
from polhode.scenes.shapes import Part, carried, together

#: What is forgiven, relative to the largest number.
GRACE = 8 * Fraction(sys.float_info.epsilon)

_PAIRS = ((0, 1), (0, 2), (1, 2))
_WIDEST = 64  # bits of a longdouble
_FINEST = 1100  # bits of the denominator of the smallest double


def are_rounded(numbers: Iterable[object]) -> bool:
    """Whether some of the numbers that were given are floats, and none is a text."""
    values = [*numbers]
    if any(isinstance(x, str) for x in values):
        return False
    return any(
        not isinstance(x, (Fraction, Irrational, Decimal)) and not hasattr(x, "__index__")
        for x in values
    )


def is_rounded_unit(numbers: Sequence[object]) -> bool:
    """Whether numbers are all doubles, of length 1 to 8 eps but not exactly."""
    exactly = [x for x in numbers if isinstance(x, (int, float, Fraction))]
    doubles = [Fraction(x) for x in exactly if _is_double(x)]
    square = sum((x**2 for x in doubles), Fraction(-1))
    return len(doubles) == len(numbers) and 0 < abs(square) <= GRACE


def _is_double(x: float | Fraction) -> bool:
    over, under = x.as_integer_ratio()
    small = abs(over).bit_length() <= _WIDEST and under.bit_length() < _FINEST
    return small and under & (under - 1) == 0


def symmetric(matrix: Matrix, rounded: bool) -> tuple[Matrix, str]:
    """A symmetric matrix as it is; one that is so to 8 eps made symmetric, and what was changed.

    ``rounded``: whether that is rounding.  Raises UnphysicalBody for any other.
    """
    gap: Exact = ZERO
    place = 0, 0
    for i, j in _PAIRS:
        x, y = matrix[i][j], matrix[j][i]
        if x is not y and x != y and abs(x - y) > gap:
            gap, place = abs(x - y), (i, j)
    if gap is ZERO:
        return matrix, ""
    if not rounded or gap > GRACE * max(abs(x) for row in matrix for x in row):
        i, j = place
        pair = f"[{i + 1}][{j + 1}] and [{j + 1}][{i + 1}]"
        raise UnphysicalBody(f"a symmetric matrix: {pair} differ by {brief(gap, 3)}; {PRODUCTS}")
    a, b, c = ((*((matrix[i][j] + matrix[j][i]) / 2 for j in range(3)),) for i in range(3))
    change = f"inertia made symmetric (elements differed by {brief(gap, 2)} at most: rounding)"
    return (a, b, c), change  # type: ignore[return-value]  # of three elements each


def excess(moments: Vector) -> Exact:
    """By how much the largest principal moment exceeds the sum of the others; below 0 if less."""
    a, b, c = moments
    return 2 * max(moments) - (a + b + c)


def flattened(matrix: Matrix, over: Exact) -> tuple[Matrix, str]:
    """The inertia of a flat body where it is that of one to 8 eps, and what was changed.

    ``over``: by how much the largest principal moment exceeds the sum of the others.  Of a diagonal
    matrix it becomes that sum; to the diagonal of any other is added what it is too much.
    """
    if over > GRACE * max(abs(x) for row in matrix for x in row):
        return matrix, ""
    rows = [[*row] for row in matrix]
    if all(sign(matrix[i][j]) == 0 for i, j in _PAIRS):
        change = "largest moment made the sum of the others"
        k = max(range(3), key=lambda i: matrix[i][i])
        rows[k][k] = rows[k][k] - over
    else:
        change = "inertia made that of a flat body, by its diagonal"
        more = over  # or a little more, where it is no fraction
        if isinstance(over, Irrational):
            more = exact.nearest(over, 30) * (1 + Fraction(1, 1 << 28))
        for i in range(3):
            rows[i][i] = rows[i][i] + more
    a, b, c = (tuple(row) for row in rows)
    words = f"{change} (the largest moment exceeded it by {brief(over, 2)}: rounding)"
    return (a, b, c), words  # type: ignore[return-value]  # of three elements each


# --- body -----------------------------------------------------------------------------------------
#
# A rigid body at its fixed point: inertia, centre of mass, weight, and its principal axes.
#
# Everything is exact. Equal moments and a centre of mass on an axis are recognised after any
# rational rotation of the axes: the characteristic polynomial tells repeated and rational moments
# exactly, and projections onto an axis are formed before the axis is scaled to length one.


IDENTITY: Matrix = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


#: What an inertia matrix is, and how a robot's description (URDF) gives the same.
MATRIX = (
    "a 3 x 3 matrix: with URDF's ixx ixy ixz iyy iyz izz it is "
    "[[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], signs unchanged"
)
PRODUCTS = "off the diagonal stand minus the products of inertia"
_NO_WAY_OUT = "; with a torque of the weight no other body moves so (of free bodies others do)"
_READABLE = 0.01  # the least c that is proposed, times the largest moment


def exact_vector(values: object, source: str = "Body", key: str = "vector") -> Vector:
    """Three numbers of any kind, taken exactly; raises BadInput."""
    numbers = each(source, key, values, derived_number, "three numbers")
    if len(numbers) != 3:
        raise BadInput(source, key, f"{len(numbers)} numbers", "three numbers")
    return numbers[0], numbers[1], numbers[2]


class UnphysicalBody(BadInput):
    """Inertia that no body has; ``expected`` says which condition fails."""

    def __init__(self, expected: str) -> None:
        super().__init__("Body", "inertia", None, expected)

    def __reduce__(self) -> tuple[type, tuple[str]]:  # type: ignore[override]
        return type(self), (self.expected,)


@dataclass(frozen=True)
class PrincipalAxes:
    """Right-handed orthonormal axes in body axes, kept as directions and squared lengths."""

    directions: Matrix
    squares: Vector

    @cached_property
    def trivial(self) -> bool:
        """Whether these are the body axes themselves."""
        return self.directions == IDENTITY

    def components(self, vector: Vector) -> Vector:
        """The components of a vector, given in body axes, along these axes."""
        if self.trivial:
            return vector
        a, b, c = (
            dot(u, vector) / exact.sqrt(n)
            for u, n in zip(self.directions, self.squares, strict=True)
        )
        return a, b, c

    @cached_property
    def rows(self) -> Matrix:
        """The unit vectors, row i being axis i in body axes: components = rows · vector."""
        if self.trivial:
            return IDENTITY
        a, b, c = (
            scaled(1 / exact.sqrt(n), u) for u, n in zip(self.directions, self.squares, strict=True)
        )
        return a, b, c


OWN_AXES = PrincipalAxes(IDENTITY, (ONE, ONE, ONE))


@dataclass(frozen=True)
class Body:
    """Inertia matrix I at the fixed point, centre of mass r0, weight Mg, in body axes.

    Any consistent units.  Off the diagonal of I stand minus the products of inertia: I_xy is
    minus the integral of x y dm.  Numbers of any kind are exact, a float the binary number that it
    is; see :func:`polhode.numbers.conversion.exact_number`.  Raises UnphysicalBody, a ValueError,
    unless I is symmetric with positive principal moments of which none exceeds the sum of the other
    two.  Where I has floats, and none of it is a text, what it lacks of that by 8 eps of its
    largest element is rounding: I is made symmetric, or that of a flat body, and ``change`` says
    so.  ``rounded`` says whether it is to be taken so, whatever the numbers.  ``parts``: the solids
    that it was made of, if any.

    ``moments``: the principal moments A, B, C in the order of ``axes``.  ``axes``: the principal
    axes; the body axes themselves where the matrix is diagonal.  Else, with two equal moments the
    third axis is the axis of symmetry and the second is at right angles to the centre of mass; with
    three different ones they are in ascending order.

    >>> import polhode
    >>> top = polhode.Body.of_moments([2, 2, 1], centre=[1, 0, 0], weight="3/2")
    >>> top.torque  # Mg r0
    (Fraction(3, 2), Fraction(0, 1), Fraction(0, 1))
    >>> polhode.Body([[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 3]]).moments
    (Fraction(3, 2), Fraction(5, 2), Fraction(3, 1))
    >>> polhode.Body.of_parts([polhode.Part("cone", 1, radius=3, height=4)], g="9.8").torque[2]
    Fraction(147, 5)
    """

    inertia: Matrix
    centre: Vector = (ZERO, ZERO, ZERO)
    weight: Exact = ZERO
    parts: tuple[Part, ...] = ()
    rounded: InitVar[bool | None] = None
    change: str = field(default="", init=False, repr=False, compare=False)
    moments: Vector = field(init=False, repr=False, compare=False)
    axes: PrincipalAxes = field(init=False, repr=False, compare=False)

    def __post_init__(self, rounded: bool | None) -> None:
        rows, several = numbers_given(self.inertia)
        if len(rows) != 3:
            raise BadInput("Body", "inertia", f"{len(rows)} rows" if several else rows[0], MATRIX)
        if rounded is None:  # looked at twice
            rows = [[*row] if numbers_given(row)[1] else row for row in rows]
        x, y, z = (exact_vector(row, key=f"inertia[{i + 1}]") for i, row in enumerate(rows))
        if rounded is None:
            rounded = are_rounded(number for row in rows for number in row)
        centre = exact_vector(self.centre, key="centre")
        (weight,) = each("Body", "weight", (self.weight,), derived_number, "a number")
        inertia, change = symmetric((x, y, z), rounded)
        if self.parts and together(self.parts)[1:] != (centre, inertia):
            raise BadInput("Body", "parts", None, "parts of this inertia and centre")
        moments, axes = principal(inertia, centre)
        over, positive = excess(moments), min(map(sign, moments)) > 0
        if rounded and positive and sign(over) > 0:
            inertia, flat = flattened(inertia, over)
            if flat:
                change, over = "; ".join(filter(None, (change, flat))), ZERO
                moments, axes = principal(inertia, centre)
        values = {"inertia": inertia, "centre": centre, "weight": weight, "change": change}
        vars(self).update(values, moments=moments, axes=axes)
        if sign(over) > 0 or not positive:
            raise self._unphysical(over, positive)

    def _unphysical(self, over: Exact, positive: bool) -> UnphysicalBody:
        """What is wrong with the principal moments; ``over``: see :func:`excess`."""
        if positive:
            expected = "principal moments of which none exceeds the sum of the others"
            amount = f", too much by {brief(over, 3)}"
            way_out = _free_body_of_same_path(self.moments) if self.torque_free else _NO_WAY_OUT
        else:
            expected, amount, way_out = "positive principal moments", "", self._as_pendulum()
        words = f"{expected}: they are {', '.join(brief(x) for x in self.moments)}{amount}"
        signs = "" if self.axes.trivial else f"; {PRODUCTS}"
        return UnphysicalBody(f"{words}{signs}{way_out}")

    def _as_pendulum(self) -> str:
        """What to write of a thin rod, or a point on one, which turn about it without any moment.

        Without a spin about the rod the third moment is in no equation: r' = 0, and in A p', A q'
        it stands beside r alone.
        """
        moments, torque = self.moments, self.axes.components(self.torque)
        across = [k for k in range(3) if sign(moments[k]) > 0 == sign(torque[k])]
        zeros = [k for k in range(3) if sign(moments[k]) == 0]
        if len(across) != 2 or len(zeros) != 1 or moments[across[0]] != moments[across[1]]:
            return ""
        body = [x if sign(x) else max(moments) / 2 for x in moments]
        return (
            "; a thin rod, or a point on one, moves as a body of any third moment without spin "
            f"about it, as {', '.join(map(shown, body))}: see lagrange/spherical-pendulum"
        )

    @classmethod
    def of_moments(
        cls, moments: AnyVector, centre: AnyVector = (0, 0, 0), weight: AnyNumber = 0
    ) -> Body:
        """A body given in principal axes by its moments A, B, C."""
        values, several = numbers_given(moments)
        return cls(
            diagonal(exact_vector(values if several else moments, key="moments")),
            centre,  # type: ignore[arg-type]  # taken exactly there
            weight,  # type: ignore[arg-type]
            rounded=several and are_rounded(values),
        )

    @classmethod
    def about_centre(
        cls,
        inertia: Iterable[AnyVector],
        centre: AnyVector,
        mass: AnyNumber,
        weight: AnyNumber = 0,
        rounded: bool | None = None,
    ) -> Body:
        """A body given by its inertia matrix about its centre of mass (Huygens and Steiner).

        ``rounded``: as of the body itself.
        """
        own = cls(inertia, centre, weight, rounded=rounded)  # type: ignore[arg-type]
        (of_mass,) = each("Body", "mass", (mass,), exact_number, "a number")
        if sign(of_mass) <= 0:
            raise BadInput("Body", "mass", mass, "a mass above 0")
        moved = carried(own.inertia, of_mass, own.centre)
        body = cls(moved, own.centre, own.weight, rounded=rounded)
        object.__setattr__(body, "change", own.change)
        return body

    @classmethod
    def of_parts(
        cls, parts: Iterable[Part], g: AnyNumber | None = None, weight: AnyNumber | None = None
    ) -> Body:
        """A body put together of homogeneous solids; ``g`` times its mass is its weight."""
        solids = tuple(parts)
        if not solids:
            raise BadInput("Body", "parts", None, "at least one Part")
        for k, part in enumerate(solids):
            of_kind("Body", f"parts[{k + 1}]", part, Part, "a Part")
        if (g is None) == (weight is None):
            raise BadInput("Body", "g", g, "one of g and weight; 0 for none")
        mass, centre, inertia = together(solids)
        if weight is None:
            (gravity,) = each("Body", "g", (g,), exact_number, "a number")
            weight = mass * gravity
        return cls(inertia, centre, weight, solids)  # type: ignore[arg-type]

    def replaced(
        self,
        *,
        inertia: Matrix | None = None,
        centre: Vector | None = None,
        weight: Exact | None = None,
    ) -> Body:
        """The same body but for what is given; raises UnphysicalBody.

        Its parts go where inertia or centre are no longer theirs.
        """
        numbers = {"inertia": inertia, "centre": centre, "weight": weight}
        changes: dict[str, Any] = {name: x for name, x in numbers.items() if x is not None}
        if inertia is not None or centre is not None:
            changes["parts"] = ()
        return replace(self, **changes)

    @cached_property
    def torque(self) -> Vector:
        """Mg r0 in body axes; exactly zero for a torque-free body."""
        if sign(self.weight) == 0 or is_zero(self.centre):
            return ZERO, ZERO, ZERO
        return scaled(self.weight, self.centre)

    @cached_property
    def pendulum_rate_fourth(self) -> Exact:
        """(Mg|r0| / largest moment)²: the slowest small oscillation's rate to the fourth power."""
        largest = max(self.moments)
        return dot(self.torque, self.torque) / (largest * largest)

    @property
    def torque_free(self) -> bool:
        """Whether gravity has no moment about the fixed point."""
        return is_zero(self.torque)

    def momentum(self, omega: Vector) -> Vector:
        """G = I w in body axes."""
        return apply(self.inertia, omega)

    def moment(self, omega: Vector, gamma: Vector | None) -> Vector:
        """I w' = Mg gamma × r0 - w × G in body axes; without gamma of a torque-free body."""
        of_weight: Vector = (ZERO, ZERO, ZERO)
        if gamma is not None and not self.torque_free:
            of_weight = cross(gamma, self.torque)
        return minus(of_weight, cross(omega, self.momentum(omega)))

    def omega(self, momentum: Vector) -> Vector:
        """w = I⁻¹ G in body axes."""
        return apply(vectors.inverse(self.inertia), momentum)


def _free_body_of_same_path(moments: Vector) -> str:
    """A free body whose momentum moves in the body as Euler's equations say for such numbers.

    G' = G × I⁻¹G stays the same where c times the identity is added to I⁻¹, since G × cG = 0, and
    omega becomes omega + cG.  With a >= b >= g the moments' inverses, 1/(a + c) + 1/(b + c) >=
    1/(g + c) is c² + 2gc + (a + b)g - ab >= 0, and so c >= sqrt((a - g)(b - g)) - g.
    """
    largest = max(moments)
    b, a = sorted(float(largest / x) for x in moments)[1:]  # g is 1
    least = max(math.sqrt(a - 1) * math.sqrt(b - 1) - 1, _READABLE)
    power = math.floor(math.log10(least) - exact.log10(largest))
    for digit in (1, 2, 5, 10, 20):
        c = digit * Fraction(10) ** power
        x, y, z = (1 / (1 / moment + c) for moment in moments)
        if digit * 10.0**power * float(largest) >= least and sign(excess((x, y, z))) <= 0:
            break
    return (
        f"; a free body of moments {shown(x)}, {shown(y)}, {shown(z)}, which are 1/(1/I + c) with "
        f"c = {shown(c)}, has the same path of the momentum G, and the angular velocity omega + c G"
    )


def diagonal(moments: Vector) -> Matrix:
    """The inertia matrix of a body given in principal axes."""
    a, b, c = moments
    return (a, ZERO, ZERO), (ZERO, b, ZERO), (ZERO, ZERO, c)


def principal(inertia: Matrix, centre: Vector) -> tuple[Vector, PrincipalAxes]:
    """The principal moments and axes of a body; see :class:`Body`.

    With I = mean·1 + K, tr K² = 6 s² and det K = 2 d, the moments are mean + 2 s cos(angle) for
    three angles with cos(3 angle) = d/s³; two of them are equal exactly where d² = s⁶.
    """
    (a, d, e), (_, b, f), (_, _, c) = inertia
    if is_zero((d, e, f)):
        return (a, b, c), OWN_AXES
    mean = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 3
    rest = _shifted(inertia, mean)
    s2 = (dot(rest[0], rest[0]) + dot(rest[1], rest[1]) + dot(rest[2], rest[2])) / 6
    half_det = dot(rest[0], cross(rest[1], rest[2])) / 2
    discriminant = s2 * s2 * s2 - half_det * half_det
    if sign(discriminant) <= 0:  # not below zero for a symmetric matrix: equal
        signed = half_det / s2
        equal, single = mean - signed, mean + 2 * signed
        third = _eigenvector(inertia, single)
        first = minus(scaled(dot(third, third), centre), scaled(dot(third, centre), third))
        if is_zero(first):  # centre on the axis of symmetry: any direction across it will do
            first = next(v for u in IDENTITY if not is_zero(v := cross(u, third)))
        return (equal, equal, single), _right_handed(first, cross(third, first))

    s, angle = exact.sqrt(s2), exact.arctan2(exact.sqrt(discriminant), half_det)
    turn = 2 * exact.pi()
    candidates = [mean + 2 * s * exact.cos((angle + k * turn) / 3) for k in (1, 2, 0)]
    a, b, c = (_rational_if_so(inertia, candidates[k:] + candidates[:k]) for k in range(3))
    return (a, b, c), _right_handed(_eigenvector(inertia, a), _eigenvector(inertia, b))


def _shifted(inertia: Matrix, moment: Exact) -> Matrix:
    (a, d, e), (_, b, f), (_, _, c) = inertia
    return (a - moment, d, e), (d, b - moment, f), (e, f, c - moment)


def _eigenvector(inertia: Matrix, moment: Exact) -> Vector:
    """A vector along the axis of a simple principal moment: the longest column of the adjugate."""
    x, y, z = _shifted(inertia, moment)
    return max((cross(y, z), cross(z, x), cross(x, y)), key=lambda v: dot(v, v))


def _right_handed(first: Vector, second: Vector) -> PrincipalAxes:
    third = cross(first, second)
    squares = dot(first, first), dot(second, second), dot(third, third)
    if any(sign(square) == 0 for square in squares):  # by the rule for *equal*
        raise UnphysicalBody(f"a matrix whose axes {exact.EQUAL_BITS} bits tell apart")
    return PrincipalAxes((first, second, third), squares)


def _rational_if_so(inertia: Matrix, moments: list[Exact]) -> Exact:
    """The first of the principal moments, a Fraction where the matrix is rational and it is too.

    Times the common denominator of the matrix a rational moment is an integer: the nearest one is
    tried in the characteristic polynomial.  A root of that which is neither of the other moments is
    this one, exactly.
    """
    moment, *others = moments
    entries = [entry for row in inertia for entry in row]
    if isinstance(moment, Fraction) or not all(isinstance(x, Fraction) for x in entries):
        return moment
    common = math.lcm(*(entry.denominator for entry in entries if isinstance(entry, Fraction)))
    scaled_moment = moment * common
    _, exponent = exact.rounded(scaled_moment, 8)
    mantissa, exponent = exact.rounded(scaled_moment, max(64, exponent + 16))
    candidate = Fraction(round(mantissa * Fraction(2) ** exponent), common)
    x, y, z = _shifted(inertia, candidate)
    root = dot(x, cross(y, z)) == 0
    return (
        candidate
        if root and all(sign(moment_beside - candidate) for moment_beside in others)
        else moment
    )


# --- classification -------------------------------------------------------------------------------
#
# Which classical top a body is, and about which axis: decided here and nowhere else.
#
# With two equal moments A = B, C the third one, T = Mg r0 and the axis of C the third:
#
#     Lagrange                 T along the axis (of three equal moments: anywhere)
#     Kovalevskaya             A = 2C, T across the axis
#     Goryachev, Chaplygin     A = 4C, T across the axis
#
# All by exact arithmetic on the body's numbers.


EULER, LAGRANGE, SPHERE = "Euler top", "Lagrange top", "Lagrange top (three equal moments)"
KOVALEVSKAYA, CHAPLYGIN = "Kovalevskaya top", "Goryachev-Chaplygin body"
SYMMETRIC = "heavy symmetric body, centre of mass off its axis"
ASYMMETRIC = "heavy asymmetric body"


class ClassicalTop(NamedTuple):
    """``kind``: the body's classical name, one of the seven above.

    ``axis``: the principal axis (0, 1 or 2) of the moment C; of three equal moments the one that
    carries the centre of mass.  None where there is no such axis, and for a body without weight.
    """

    kind: str
    axis: int | None = None


def classical_top(moments: Vector, torque: Vector) -> ClassicalTop:
    """What a body is, by its principal moments and T = Mg r0 in principal axes."""
    if is_zero(torque):
        return ClassicalTop(EULER)
    spherical = moments[0] == moments[1] == moments[2]
    for axis in (2, 0, 1):
        i, j, k = with_last(axis)
        if moments[i] != moments[j]:
            continue
        if sign(torque[i]) == 0 == sign(torque[j]):
            return ClassicalTop(SPHERE if spherical else LAGRANGE, axis)
        if spherical:
            continue
        if sign(torque[k]) == 0 and moments[i] == 2 * moments[k]:
            return ClassicalTop(KOVALEVSKAYA, axis)
        if sign(torque[k]) == 0 and moments[i] == 4 * moments[k]:
            return ClassicalTop(CHAPLYGIN, axis)
        return ClassicalTop(SYMMETRIC, axis)
    return ClassicalTop(SPHERE if spherical else ASYMMETRIC)


def with_last(axis: int) -> tuple[int, int, int]:
    """The three axes in cyclic order, ``axis`` last: a right-handed frame stays so."""
    return (axis + 1) % 3, (axis + 2) % 3, axis


def kind_of_body(body: Body) -> str:
    """The classical name of a body: Euler, Lagrange or Kovalevskaya top, or what it is instead."""
    return classical_top(body.moments, body.axes.components(body.torque)).kind
