"""Random exact scenes for the forms, and what every form must do, in plain mpmath.

The field of a form is held against the vector equations I w' + w x I w = Mg gamma x r0,
gamma' = gamma x w, written here with the full inertia matrix.
"""

from fractions import Fraction

from hypothesis import strategies as st

from polhode.numbers.conversion import to_mpf
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.number_types import DOUBLE, mp
from polhode.numbers.scalars import Functions
from polhode.scenes.body import OWN_AXES, Body
from polhode.scenes.scene import Scene
from shared.form_integrals import form_integrals

F = Fraction
DIGITS = 50
WORKING = 140  # a central difference over 1e-40 leaves errors of 1e-80 and 1e-100
STEP = mpf(10) ** -40
MP = Functions(mpf(0), mpmath.sin, mpmath.cos, mpmath.sqrt)

parts = st.integers(-40, 40)


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
    a, b, c, d = draw(st.tuples(*[st.integers(-4, 4)] * 4).filter(any))
    n = a * a + b * b + c * c + d * d
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return [[Fraction(x, n) for x in row] for row in rows]


def turned(rotation, vector):
    return tuple(sum(a * x for a, x in zip(row, vector, strict=True)) for row in rotation)


def turned_inertia(rotation, moments):
    return tuple(
        tuple(sum(a * m * b for a, m, b in zip(u, moments, v, strict=True)) for v in rotation)
        for u in rotation
    )


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
def scenes(draw, kind="any", heavy=False, turn=True):
    """A scene with a general centre, some of its components 0, in turned axes or principal ones."""
    I = draw(moments(kind))
    centre = [draw(rational(-2, 2)) for _ in range(3)]
    if heavy and not any(centre):
        centre[2] = Fraction(1)
    weight = Fraction(draw(st.integers(1, 9)), 2)
    omega, gamma = tuple(draw(rational(-3, 3)) for _ in range(3)), draw(unit_vectors())
    if not (turn and draw(st.booleans())):
        return Scene(Body.of_moments(I, centre, weight), omega, gamma, psi=Fraction(1, 3))
    R = draw(rotations())
    inertia = [
        [sum(R[i][m] * I[m] * R[j][m] for m in range(3)) for j in range(3)] for i in range(3)
    ]
    body = Body(tuple(map(tuple, inertia)), turned(R, centre), weight)
    return Scene(body, turned(R, omega), turned(R, gamma), psi=Fraction(1, 3))


def numbers(form, working=WORKING):
    """The start and the coefficients as mpf."""
    bits = mp(working).bits
    k = {name: to_mpf(x, bits) for name, x in form.coefficients.items()}
    return [to_mpf(x, bits) for x in form.start], k


def along(axes, vector, working=WORKING):
    """A vector of components along ``axes``, in the scene's axes."""
    if axes is OWN_AXES:
        return list(vector)
    rows = [[to_mpf(x, mp(working).bits) for x in row] for row in axes.rows]
    return [mpmath.fsum(rows[i][j] * vector[i] for i in range(3)) for j in range(3)]


def state(form, values, k):
    """w and gamma in the scene's axes and its own unit of time."""
    omega, gamma = form.state(values, k, MP)
    unit = mpf(2) ** form.scene.time_unit
    return [x / unit for x in along(form.axes, omega)] + along(form.axes, gamma)


def vector_field(scene, row):
    """w' and gamma' by the vector equations, in the scene's axes and units."""
    bits = mp(WORKING).bits
    I = mpmath.matrix([[to_mpf(x, bits) for x in line] for line in scene.body.inertia])
    omega, gamma = row[:3], row[3:]
    G = list(I * mpmath.matrix(omega))
    torque = [to_mpf(x, bits) for x in scene.body.torque]
    moment = [a - b for a, b in zip(cross(gamma, torque), cross(omega, G), strict=True)]
    return [*mpmath.lu_solve(I, mpmath.matrix(moment)), *cross(gamma, omega)]


def moved(values, rates, step):
    return [x + step * v for x, v in zip(values, rates, strict=True)]


def derivative(function, values, rates, step=STEP):
    """The derivative of a vector function along ``rates``."""
    ends = function(moved(values, rates, step)), function(moved(values, rates, -step))
    return [(a - b) / (2 * step) for a, b in zip(*ends, strict=True)]


def check_start_and_field(form):
    """The start is the scene's, and the field carries the state as the vector equations do."""
    with mpmath.workdps(WORKING):
        scene, (values, k) = form.scene, numbers(form)
        row, exact = state(form, values, k), [to_mpf(x, mp(WORKING).bits) for x in scene.start]
        assert close(row, exact)
        rates = form.field(values, k, MP)
        unit = mpf(2) ** scene.time_unit
        found = derivative(lambda x: state(form, x, k), values, rates)
        assert close([x / unit for x in found], vector_field(scene, row))


def check_integrals(form):
    """Each integral has the scene's value and no derivative along the field."""
    with mpmath.workdps(WORKING):
        scene, (values, k) = form.scene, numbers(form)
        unit, bits = mpf(2) ** scene.time_unit, mp(WORKING).bits
        truth = scene.integrals
        values_of = {
            "h": to_mpf(truth.energy, bits) * unit**2,
            "f": to_mpf(truth.area, bits) * unit,
            "gamma": mpf(1),
        }
        found = form_integrals(form, values, k, MP)
        assert found
        assert close([*found.values()], [values_of[name] for name in found])
        rates = form.field(values, k, MP)
        drift = derivative(lambda x: [*form_integrals(form, x, k, MP).values()], values, rates)
        assert close(drift, [0] * len(drift))


def close(found, expected, digits=DIGITS):
    scale = 1 + max(abs(x) for x in expected)
    return max(abs(a - b) for a, b in zip(found, expected, strict=True)) < scale * 10 ** mpf(
        -digits
    )


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return mpmath.fdot(a, b)


def marched(form, times, number=DOUBLE):
    """The form's variables at the times (the scene's unit) by heyoka, the run and its outcome."""
    from polhode.taylor.backend import heyoka_numbers
    from polhode.taylor.integrator import specification, stepping

    plan = specification.Blueprint(
        form.variables,
        lambda values, k: form.field(values, k, heyoka_numbers.EXPRESSIONS),
        form.coefficients,
        form.start,
        number,
    )
    run = stepping.Integrator(plan)
    unit = F(2) ** form.scene.time_unit
    rows, outcome = run.chunk([F(t) / unit for t in times], 10**6)
    return rows, run, outcome


def integrated(form, times, number):
    """The same with w and gamma in scene axes for the variables."""
    rows, run, outcome = marched(form, times, number)
    with mpmath.workprec(number.bits + 20):
        k = {name: to_mpf(x, number.bits) for name, x in form.coefficients.items()}
        return [state(form, [mpf(x) for x in row], k) for row in rows], run, outcome


def both_runs(name, **changes):
    """States in double of a turned asymmetric body, in the principal form and in another."""
    import polhode

    R = [[F(2, 3), F(-1, 3), F(2, 3)], [F(2, 3), F(2, 3), F(-1, 3)], [F(-1, 3), F(2, 3), F(2, 3)]]
    I, pairs = (F(2), F(3, 2), F(1)), range(3)
    inertia = tuple(
        tuple(sum(R[i][m] * I[m] * R[j][m] for m in pairs) for j in pairs) for i in pairs
    )
    body = Body(inertia, turned(R, (F(3, 10), F(1, 5), F(1, 2))), 1)
    start = turned(R, (F(3, 10), F(1, 5), 3)), turned(R, (F(3, 5), F(0), F(4, 5)))
    times = tuple(F(i, 2) for i in range(1, 21))
    runs = [Scene(body, *start, times=times, form=form, **changes) for form in ("principal", name)]
    return [polhode.integrate(scene).states for scene in runs]
