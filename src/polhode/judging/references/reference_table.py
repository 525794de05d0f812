"""The closed form of a scene as a table: what ``polhode reference`` prints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from polhode.common.errors import BadInput
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import reference
from polhode.judging.references.reference_rows import ReferenceTable, tabulated
from polhode.numbers.scalars import AnyNumber
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS


def reference_table(
    scene: Scene | str | Path,
    at: Iterable[AnyNumber] | None = None,
    digits: int = 50,
    outputs: Iterable[str] | None = None,
    backend: str = "flint",
) -> ReferenceTable:
    """Tabulate the closed form of a scene, every printed digit right; no integration.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    at : iterable of numbers, optional
        The times, in the scene's unit; the scene's own by default.
    digits : int
        Correct digits of each number.
    outputs : iterable of str, optional
        Words of what is tabulated beside the state; the scene's own by default.
    backend : {"flint", "mpmath"}
        As of :func:`polhode.reference`; mpmath has states alone.

    Returns
    -------
    ReferenceTable
        The rows, with proven bounds of the errors where the closed form has them.

    Raises
    ------
    BadInput
        A scene without a closed form, or times or outputs that it does not have.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.reference_table("lagrange/nutation", at=["1/3"], digits=30)
    >>> found.fact("reference"), found.fact("proven")
    ('lagrange', True)
    """
    scene = library.load(scene, takes=REQUESTS)
    if outputs is not None:
        scene = replace(scene, outputs=tuple(outputs))
    if at is not None:
        scene = scene.at(at)
    if not len(scene.times):
        raise BadInput(scene.name, "run.end", None, "a time, or times given")
    if backend == "mpmath" and outputs is None:
        scene = replace(scene, outputs=())  # it has states alone
    found = reference(scene, backend)
    if isinstance(found, Certified):
        expected = "a scene with a closed form, or polhode.certify"
        raise BadInput(scene.name, "reference", found.regime, expected)
    return tabulated(found, digits)
