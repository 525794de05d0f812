"""The words that a scene file may use, and the names of columns."""

from __future__ import annotations

from typing import Literal, TypeAlias

#: What ``reference.kind`` may ask for: the first that fits, a closed form by the name of its family
#: (polhode.closed_forms.families), a proven enclosure, or two integrations.
REFERENCES = (
    *("auto", "euler", "lagrange", "kovalevskaya", "pendulum", "staude", "bobylev-steklov"),
    *("grioli", "goryachev-chaplygin", "hess", "steklov", "goryachev", "n-kowalewski"),
    *("chaplygin", "certified", "two-precisions"),
)


#: The forms of the equations (polhode.equations.forms), in the order of the source.
FORMS = (
    *("general", "inertia-axes", "principal", "momentum", "gyration-axes"),
    *("lagrangian", "hamiltonian", "routhian", "omega-only", "momentum-only", "quaternion"),
)


OUTPUTS = ("angles", "attitude", "hodographs")


STATE = ("p", "q", "r", "gamma1", "gamma2", "gamma3")


ANGLES = ("psi", "theta", "phi")


ATTITUDE = ("q0", "q1", "q2", "q3")


SPACE = ("omega_x", "omega_y", "omega_z")  # omega along the axes of space, z up


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

#: Which of the two spins on a level of h and f.
SIGNS = ("+", "-")


#: Figures of several panels, and of one.
Several: TypeAlias = Literal["angles", "hodographs", "sphere", "integrals", "error"]
Single: TypeAlias = Literal["omega", "momentum", "attitude"]
