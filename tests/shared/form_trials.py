"""Random exact scenes for the forms, and what every form must do, in plain mpmath.

The field of a form is held against the vector equations I w' + w x I w = Mg gamma x r0,
gamma' = gamma x w, written here with the full inertia matrix.
"""

from fractions import Fraction

from hypothesis import strategies as st

from polhode.numbers.conversion import to_mpf
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.number_types import Functions, mp
from polhode.numbers.vectors import cross
from polhode.scenes.body import OWN_AXES, Body
from polhode.scenes.scene import Scene
from shared import members

DIGITS = 50
WORKING = 140  # a central difference over 1e-40 leaves errors of 1e-80 and 1e-100
BITS = mp(WORKING).bits
STEP = mpf(10) ** -40
MP = Functions(mpf(0), mpmath.sin, mpmath.cos, mpmath.sqrt)


def rational(low, high):
    return st.integers(low * 12, high * 12).map(lambda n: Fraction(n, 12))


@st.composite
def unit_vectors(draw):
    """A rational unit vector, by stereographic projection, neither vertical nor nearly so."""
    u, v = Fraction(draw(st.integers(3, 20)), 10), Fraction(draw(st.integers(-20, 20)), 10)
    n = 1 + u * u + v * v
    return 2 * u / n, 2 * v / n, (n - 2) / n


@st.composite
def rotations(draw):
    """A rational rotation, from an integer quaternion."""
    return members.rotation(*draw(st.tuples(*[st.integers(-4, 4)] * 4).filter(any)))


def rotated_vector(rotation, vector):
    return tuple(sum(a * x for a, x in zip(row, vector, strict=True)) for row in rotation)


def turned_scene(rotation, scene, **changes):
    """The same motion of the body in axes that are turned."""
    columns = [rotated_vector(rotation, column) for column in scene.body.inertia]  # R I, by columns
    rows = [rotated_vector(rotation, row) for row in zip(*columns, strict=True)]
    body = Body(tuple(rows), rotated_vector(rotation, scene.body.centre), scene.body.weight)
    start = rotated_vector(rotation, scene.omega), rotated_vector(rotation, scene.gamma)
    return Scene(body, *start, psi=scene.psi, **changes)


@st.composite
def moments(draw, kind="any"):
    """Three moments that a body can have: its mass moments, summed in pairs."""
    a, b, c = (draw(rational(1, 5)) for _ in range(3))
    return {
        "any": (b + c, c + a, a + b),
        "A = B": (a + c, a + c, 2 * a),
        "A = C": (a + c, 2 * a, a + c),
        "B = C": (2 * a, a + c, a + c),
        "A = B = C": (2 * a, 2 * a, 2 * a),
    }[kind]


@st.composite
def scenes(draw, kind="any", turn=True):
    """A scene with a general centre, some of its components 0, in turned axes or principal ones."""
    I = draw(moments(kind))
    centre = [draw(rational(-2, 2)) for _ in range(3)]
    weight = Fraction(draw(st.integers(1, 9)), 2)
    omega, gamma = tuple(draw(rational(-3, 3)) for _ in range(3)), draw(unit_vectors())
    scene = Scene(Body.of_moments(I, centre, weight), omega, gamma, psi=Fraction(1, 3))
    return turned_scene(draw(rotations()), scene) if turn and draw(st.booleans()) else scene


def numbers(form):
    """The start and the coefficients as mpf."""
    k = {name: to_mpf(x, BITS) for name, x in form.coefficients.items()}
    return [to_mpf(x, BITS) for x in form.start], k


def along(axes, vector):
    """A vector of components along ``axes``, in the scene's axes."""
    if axes is OWN_AXES:
        return list(vector)
    rows = [[to_mpf(x, BITS) for x in row] for row in axes.rows]
    return [mpmath.fsum(rows[i][j] * vector[i] for i in range(3)) for j in range(3)]


def state(form, values, k):
    """w and gamma in the scene's axes and its own unit of time."""
    omega, gamma = form.state(values, k, MP)
    axes, unit = form.frame.axes, mpf(2) ** form.frame.exponent
    return [x / unit for x in along(axes, omega)] + along(axes, gamma)


def vector_field(scene, row):
    """w' and gamma' by the vector equations, in the scene's axes and units."""
    I = mpmath.matrix([[to_mpf(x, BITS) for x in line] for line in scene.body.inertia])
    omega, gamma = row[:3], row[3:]
    G = list(I * mpmath.matrix(omega))
    torque = [to_mpf(x, BITS) for x in scene.body.torque]
    moment = [a - b for a, b in zip(cross(gamma, torque), cross(omega, G), strict=True)]
    return [*mpmath.lu_solve(I, mpmath.matrix(moment)), *cross(gamma, omega)]


def derivative(function, values, rates):
    """The derivative of a vector function along ``rates``."""
    ends = [
        function([x + step * v for x, v in zip(values, rates, strict=True)])
        for step in (STEP, -STEP)
    ]
    return [(a - b) / (2 * STEP) for a, b in zip(*ends, strict=True)]


def close(vector, expected, digits=DIGITS):
    """Whether two vectors agree, by the size of the second or by 1."""
    scale = 1 + max(abs(x) for x in expected)
    worst = max(abs(a - b) for a, b in zip(vector, expected, strict=True))
    return worst < scale * 10 ** mpf(-digits)
