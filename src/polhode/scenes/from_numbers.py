"""A scene from plain numbers in Python: the keys of a scene file, given as arguments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Never

from polhode.common.arguments import each, of_kind, refuse_unknown
from polhode.common.errors import BadInput, plain
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.scenes import scene_file, vocabulary
from polhode.scenes.scene import Event, Scene
from polhode.scenes.scene_file import owned, written
from polhode.scenes.shapes import Part


def top(
    *,
    moments: AnyVector | None = None,
    inertia: Iterable[AnyVector] | None = None,
    parts: Sequence[Part | Mapping[str, object]] | None = None,
    about: str | None = None,
    centre: AnyVector | None = None,
    weight: AnyNumber | None = None,
    mass: AnyNumber | None = None,
    g: AnyNumber | None = None,
    omega: AnyVector | None = None,
    momentum: AnyVector | None = None,
    rates: AnyVector | None = None,
    gamma: AnyVector | None = None,
    psi: AnyNumber | None = None,
    angles: AnyVector | None = None,
    quaternion: Iterable[AnyNumber] | None = None,
    mrp: AnyVector | None = None,
    matrix: Iterable[AnyVector] | None = None,
    normalise: bool = False,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    p_phi: AnyNumber | None = None,
    sign: str | None = None,
    end: AnyNumber | None = None,
    samples: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    form: str | None = None,
    outputs: Sequence[str] = (),
    events: Sequence[Event | Mapping[str, object]] = (),
    reference: str | None = None,
    title: str = "",
    units: str | None = None,
    name: str = "top",
    **unknown: Never,
) -> Scene:
    """Make a scene from plain numbers, without a file: the arguments are the keys of a scene file.

    Numbers of any kind are exact: a float is the binary number that it is, which
    :func:`polhode.as_toml` shows; the text "0.1" is one tenth, "600 rpm" a number with its unit.

    Parameters
    ----------
    moments : vector, optional
        The principal moments of inertia about the fixed point.
    inertia : 3 vectors, optional
        Or the whole inertia matrix about it, [[Ixx, Ixy, Ixz], [Ixy, Iyy, Iyz], [Ixz, Iyz, Izz]]:
        off the diagonal stand minus the products of inertia, Ixy = -∫ x y dm (as in URDF; some
        drawing programs list them without the minus).  Floats that are symmetric, or those of a
        flat body, but for their rounding (8 eps) are made so, and ``Scene.notes`` says it.
    parts : sequence of Part or mapping, optional
        Or solids by shape.
    about : {"fixed point", "centre"}, optional
        What moments or inertia are about; "centre" of mass needs ``mass``.
    centre : vector, optional
        The centre of mass r0 from the fixed point, in body axes.
    weight, mass, g : number, optional
        ``weight`` = Mg, or ``mass`` and ``g``.
    omega, momentum, rates : vector, optional
        The start: the angular velocity, or the momentum I·omega, both in body axes, or the rates of
        psi, theta, phi.
    gamma : vector, optional
        The upward vertical in body axes, of length 1.  Floats of length 1 but for their rounding
        (8 eps) are brought to length 1, and the scene's text and ``Scene.notes`` say so.
    psi : number, optional
        The precession angle at the start, with ``gamma``.
    angles : vector, optional
        Or psi, theta, phi.
    quaternion : 4 numbers, optional
        Or the attitude, body to space, scalar first.
    mrp : vector, optional
        Or its modified Rodrigues parameters, the axis times tan(angle/4).
    matrix : 3 vectors, optional
        Or the rotation matrix, row by row; floats of a rotation but for their rounding (8 eps) are
        made one.
    normalise : bool
        Bring gamma or the quaternion to length 1, make a rotation of the matrix.
    h, f : number, optional
        Or the energy h and the area integral f: omega is then one of the two on that level in the
        given orientation.
    p_phi : number, optional
        With them also the momentum about the body's third axis, C r of a top (Goldstein's p_psi;
        his p_phi is f, his E is h): theta grows at the start, or a top without an orientation
        begins at the smaller theta where its nutation turns.
    sign : {"+", "-"}, optional
        Which of the two; with ``p_phi`` "-" where theta decreases, or at the larger theta.
    end : number, optional
        The last output time, in the scene's unit of time; may be negative.
    samples : int, optional
        The number of equally spaced output times from 0 to ``end``, both included.
    at : iterable of numbers, optional
        Or the output times themselves.
    form : str, optional
        The form of the equations.
    outputs : sequence of str
        More outputs: "attitude", "angles" and others.
    events : sequence of Event or mapping
        Zeros to find along the motion.
    reference : str, optional
        The reference that judges runs, instead of the one that is found.
    title : str
        A title of one line.
    units : {"SI"}, optional
        Left out for any consistent units.
    name : str
        The name in messages.
    **unknown
        No other argument is accepted; one is refused with the nearest known names.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    BadInput
        A ValueError: the argument, its value and what was expected.

    Warns
    -----
    UserWarning
        Input that is possible, and hardly meant: theta of more than a turn, without a unit.

    See Also
    --------
    load : a scene from a file; ``polhode guide scene`` explains each key.

    Examples
    --------
    >>> import polhode
    >>> spun = polhode.top(moments=[1, 1, 0.5], centre=[0, 0, 1], weight=2,
    ...                    angles=[0, 0.5, 0], rates=[0, 0, 8], end=10, samples=101)
    >>> spun
    <Scene top: moments 1, 1, 1/2, 101 times to t = 10>
    >>> polhode.reference(spun).regime
    'cusped'
    >>> polhode.top(moments=[1, 1, 0.1], omega=[0, 0, 1]).body.moments[2]
    Fraction(3602879701896397, 36028797018963968)
    """
    of_kind("top", "name", name, str, "text")
    of_kind(name, "start.normalise", normalise, bool, "True or False")
    refuse_unknown(name, top, unknown, **vocabulary.OF_OTHERS)
    values = {key: value for key, value in locals().items() if value is not None}
    data: dict[str, Any] = {
        section: {
            key.name: values[key.name] for key in vocabulary.KEYS[section] if key.name in values
        }
        for section in ("body", "start", "run")
    }
    if not normalise:
        del data["start"]["normalise"]
    if parts is not None:
        expected = "a list of Part, or of mappings"
        listed = each(name, "body.parts", parts, lambda part: part, expected)
        data["body"]["parts"] = [_table(name, "body.parts", k, x) for k, x in enumerate(listed)]
        if units is None and any(isinstance(part, Part) and part.units for part in listed):
            units = "SI"
    data["events"] = [
        _table(name, "events", k, x)
        for k, x in enumerate(each(name, "events", events, lambda event: event, "events"))
    ]
    data |= {"schema": 1, "title": title, "units": units, "reference": {"kind": reference}}
    data = owned(data, name)  # written when the caller may have changed or used it up
    scene = scene_file.of_tables(data, name, lambda: written(data, name))
    if scene.change:  # gamma or the quaternion was brought to length 1: its text is to say so
        data["start"]["normalise"] = True
    scene.speak()
    return scene


def _table(name: str, section: str, index: int, value: object) -> Mapping[str, object]:
    """The keys of a Part, an Event, or of a mapping; raises BadInput."""
    if isinstance(value, (Part, Event)):
        return value.table
    if not isinstance(value, Mapping):
        kind = "a Part" if section == "body.parts" else "an Event"
        expected = f"{kind}, or a mapping of its keys"
        raise BadInput(name, f"{section}[{index + 1}]", plain(value), expected)
    return value
