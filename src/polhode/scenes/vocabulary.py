"""The words that a scene file may use, and the names of columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple, TypeAlias

#: What ``reference.kind`` may ask for: the first that fits, a closed form by the name of its family
#: (polhode.closed_forms.families), or a proven enclosure.
REFERENCES = (
    *("auto", "euler", "lagrange", "kovalevskaya", "pendulum", "staude", "bobylev-steklov"),
    *("grioli", "goryachev-chaplygin", "hess", "steklov", "goryachev", "n-kowalewski"),
    *("chaplygin", "certified"),
)
#: What earlier versions took for ``reference.kind``, and what to write instead.
FORMER_REFERENCES = {"two-precisions": "auto, or certified for a proven enclosure"}


#: The forms of the equations (polhode.equations.forms), in the order of the source.
FORMS = (
    *("general", "inertia-axes", "principal", "momentum", "gyration-axes"),
    *("lagrangian", "hamiltonian", "routhian", "omega-only", "momentum-only", "quaternion"),
)


#: What a scene may ask for beyond its motion in the principal form; most doors need not know it.
REQUESTS = ("form", "outputs", "events")


STATE = ("p", "q", "r", "gamma1", "gamma2", "gamma3")


ANGLES = ("psi", "theta", "phi")


ATTITUDE = ("q0", "q1", "q2", "q3")


MATRIX = tuple(f"R{i}{j}" for i in "123" for j in "123")  # body to space, row by row


RODRIGUES = ("sigma1", "sigma2", "sigma3")  # modified: the axis times tan(angle / 4)


INTEGRALS = ("h", "f", "drift_h", "drift_f", "drift_gamma", "drift_fourth")


SPACE = ("omega_x", "omega_y", "omega_z")  # omega along the axes of space, z up


class ColumnWord(NamedTuple):
    """What a word of ``run.outputs`` adds to a trajectory.

    ``names``: of its columns, in CSV files and frames.  ``needs``: what it is made of: "state", or
    integrated words.  ``how``: integrated beside the state, or derived from what it needs, by the
    formula in polhode.equations.columns.  ``meaning``: for the guide.
    """

    names: tuple[str, ...]
    needs: tuple[str, ...]
    how: Literal["integrated", "derived"]
    meaning: str


#: The words of ``run.outputs``, in the order of a trajectory's columns.
COLUMNS: Mapping[str, ColumnWord] = {
    "angles": ColumnWord(
        ANGLES,
        ("state",),
        "integrated",
        "in radians, continuous in time; empty at a pole, where psi and phi have no meaning",
    ),
    "attitude": ColumnWord(
        ATTITUDE,
        ("state",),
        "integrated",
        "unit quaternion, body to space, scalar first; at the start the first component that is "
        "not 0 is positive, then continuous",
    ),
    "hodographs": ColumnWord(
        SPACE, ("state", "attitude"), "derived", "omega along the axes of space, z up"
    ),
    "matrix": ColumnWord(
        MATRIX, ("attitude",), "derived", "the rotation matrix, body to space, row by row"
    ),
    "mrp": ColumnWord(
        RODRIGUES,
        ("attitude",),
        "derived",
        "modified Rodrigues parameters, the axis times tan(angle/4), of the quaternion with its "
        "sign: continuous, empty where it is -1",
    ),
    "integrals": ColumnWord(
        INTEGRALS,
        ("state",),
        "derived",
        "energy and vertical momentum, and how far they, the length of gamma and a fourth integral "
        "are from the start's, relative; without a fourth integral the last one is empty",
    ),
}


def column_names() -> list[str]:
    """The names of all columns beside t and the state."""
    return [name for word in COLUMNS.values() for name in word.names]


ANGLE_VARIABLES = ("psi", "phi")  # of the angles, those that are integrated along


#: Events known by name: theta' = 0, the third axis horizontal, w along the middle principal axis
#: changing sign (no expression in scene axes), and a Poincaré section, followed by its expression.
FLIP, SECTION = "flip", "section:"


#: Sections that every orbit crosses, and which of their extrema are taken.
SECTIONS, EXTREMA = ("momentum", "height"), ("max", "min")


READY_MADE = {"nutation": "p*gamma2 - q*gamma1", "equator": "gamma3", FLIP: None}

#: In which direction an event's expression passes zero, as t grows.
DIRECTIONS = ("rising", "falling", "any")

#: What moments of inertia may be about.
FIXED_POINT, CENTRE = "fixed point", "centre"

#: Systems of units that a scene may say its numbers are in; "": any consistent one.
UNITS = ("", "SI")

#: Which of the two spins on a level of h and f.
SIGNS = ("+", "-")


#: Figures of several panels, and of one.
Several: TypeAlias = Literal["angles", "hodographs", "sphere", "integrals", "error"]
Single: TypeAlias = Literal["omega", "momentum", "attitude"]
