"""Which terms of somebody's equations differ from the body's: their coefficients, solved for.

    I w' = -w x I w + Mg gamma x r0,    gamma' = gamma x w

In w and gamma, or in the momentum G = I w and gamma, each rate is a polynomial of degree two.  A
right-hand side is evaluated at states of the body, gamma of length 1, and the coefficients of all
monomials are solved for by least squares; what is left says whether it is such a polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations_with_replacement, permutations
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, counted
from polhode.equations.form import field
from polhode.judging.tables.hypotheses import other_scenes
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.results.cells import DOUBLE, TEXT
from polhode.results.result import Result
from polhode.results.table import Fact, Table, table_of_rows
from polhode.scenes import library
from polhode.scenes.body import exact_vector
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts
from polhode.scenes.vocabulary import REQUESTS

_STATES = 120  # at which a right-hand side is evaluated
_LATER = 5  # of them at another time, too
_LEAST = 1e-9  # of a coefficient: one that differs by less is typed in decimals
_ROUNDING, _NOISE = 1e-12, 1e2  # of a rate's largest size, likewise; times what is left of rates
_MOST = 1e-5  # what is left of the rates of a polynomial, in single precision too
_FEW = 12  # coefficients that are listed in words
_NEAR = 1e-6  # of a ratio that has a name

#: Ratios of terms that have a name.
_PLAIN = {
    0.0: "is missing",
    -1.0: "has the other sign",
    2.0: "is twice the right one",
    0.5: "is half the right one",
    -2.0: "is twice the right one, of the other sign",
}

#: Names of the variables; a rate is called by its variable and a prime.
VARIABLES = {
    "omega": ("p", "q", "r", "gamma1", "gamma2", "gamma3"),
    "momentum": ("G1", "G2", "G3", "gamma1", "gamma2", "gamma3"),
}

#: A right-hand side: of t and the six variables, or three without gamma.
Field = Callable[[float, Doubles], npt.ArrayLike]
#: Places of variables, at most two: a monomial.
Monomial = tuple[int, ...]


class Difference(NamedTuple):
    """A coefficient that differs: of which rate, of which monomial, the right one and the other."""

    rate: str
    term: str
    right: float
    coefficient: float

    @property
    def _of(self) -> str:
        return "" if self.term == "1" else f" in {self.term}"

    def __str__(self) -> str:
        if not self.right:
            return f"{self.rate} has a term {self.coefficient:.6g}{self._of}, not in the equations"
        ratio = _ratio(self.coefficient / self.right)
        words = f"{self.rate}: the term{self._of} {ratio}"
        if not self.coefficient:
            return words
        return f"{words}, {self.coefficient:.6g} for {self.right:.6g}"


@dataclass(frozen=True, repr=False)
class FieldComparison(Result):
    """The terms of a right-hand side f(t, y) that differ from those of a scene's equations.

    ``differences``: the coefficients that differ.  ``terms``: the same in words, whole terms where
    they differ as a whole.  ``residual``: what is left of f beside a polynomial of degree two, over
    the size of the rates.  ``variables``: "omega" or "momentum".

    >>> import numpy as np, polhode
    >>> f, signs = polhode.field("lagrange/nutation"), np.repeat([1, -1], 3)
    >>> found = polhode.compare_field(lambda t, y: signs * f(t, y), "lagrange/nutation")
    >>> found.right, found.terms
    (False, ("gamma' = gamma x omega has the other sign",))
    """

    scene: Scene
    variables: str
    differences: tuple[Difference, ...]
    terms: tuple[str, ...]
    residual: float

    @property
    def polynomial(self) -> bool:
        """Whether f is a polynomial of degree two, as the equations are."""
        return self.residual < _MOST

    @property
    def right(self) -> bool:
        """Whether f is the scene's field."""
        return not self.terms

    def table(self) -> Table:
        """A row a coefficient that differs."""
        types = {"rate": TEXT, "term": TEXT, "right": DOUBLE, "coefficient": DOUBLE}
        return table_of_rows(types, [*self.differences], labels=2)

    def facts(self) -> list[Fact]:
        """Whether it is right, and what differs, in words."""
        return [
            *scene_facts(self.scene),
            Fact("variables", self.variables, "of the right-hand side, beside gamma"),
            Fact("right", self.right, "whether all terms are"),
            Fact("polynomial", self.polynomial, "whether it is one of degree two"),
            Fact("residual", self.residual, "what is left beside such a one, over the rates"),
            Fact("terms", list(self.terms), "what differs, in words", type=TEXT),
            provenance_fact(self.scene.provenance()),
        ]

    def __repr__(self) -> str:
        words = "every term is right" if self.right else f"{counted(len(self.terms), 'difference')}"
        return f"<FieldComparison with {self.scene.name}: {words}>"

    def __str__(self) -> str:
        if self.right:
            told = max(_LEAST, _NOISE * self.residual)  # what differs by less is called right
            return f"every term is that of {self.scene.name}, to {told:.1g} of the rates"
        more = len(self.terms) - _FEW
        shown = [*self.terms[:_FEW], *([f"and {more} more"] if more > 0 else [])]
        return "\n".join([f"not the equations of {self.scene.name}:", *shown])


def compare_field(
    f: Field, scene: Scene | str | Path, variables: Literal["omega", "momentum"] = "omega"
) -> FieldComparison:
    """Name the terms of a right-hand side that differ from those of a scene's equations.

    Parameters
    ----------
    f : callable
        f(t, y) -> the rates of y: p q r gamma1 gamma2 gamma3 in the scene's body axes and units, or
        G1 G2 G3 gamma1 gamma2 gamma3; the first three alone where the scene has no gamma.
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    variables : {"omega", "momentum"}
        Whether y begins with the angular velocity or with the angular momentum G = I omega.

    Returns
    -------
    FieldComparison
        What differs: whole terms where they are missing, of the other sign or a multiple, those of
        a body that may be meant, else single coefficients; ``right`` where nothing does.

    Raises
    ------
    BadInput
        A scene that cannot be read, or an f that does not return as many finite numbers.

    Notes
    -----
    The equations are ::

        I w' = -w × I w + Mg gamma × r0,    gamma' = gamma × w

    (3.16-3.17) of Yehia, *Rigid Body Dynamics: A Lagrangian Approach*.  f is evaluated at 120
    states with gamma of length 1, as all states of the body are: what f does elsewhere is not seen.
    A coefficient is right to 1e-9, and where it adds no more than 1e-12 of a rate's largest size;
    of an f in single precision, no more than that rounds.

    Examples
    --------
    >>> import numpy as np, polhode
    >>> A = np.array([1, 1, 0.5])
    >>> def f(t, y):
    ...     w, gamma = y[:3], y[3:]
    ...     torque = np.cross(gamma, [0, 0, 1])
    ...     return np.concatenate([(np.cross(w, A * w) + torque) / A, np.cross(gamma, w)])
    >>> print(polhode.compare_field(f, "lagrange/nutation"))
    not the equations of lagrange/nutation:
    the gyroscopic term -omega x I omega has the other sign
    """
    if not callable(f):
        raise BadInput("compare_field", "f", f, "a function f(t, y) that returns the rates of y")
    if not isinstance(variables, str) or variables not in VARIABLES:
        raise BadInput("compare_field", "variables", variables, " or ".join(VARIABLES))
    of_kind("compare_field", "scene", scene, (Scene, str, Path), "a scene")
    return _Fitted(f, library.load(scene, takes=REQUESTS), variables).comparison()


class _Fitted:
    """A right-hand side beside a scene's, by coefficients."""

    def __init__(self, f: Field, scene: Scene, variables: str) -> None:
        self.scene, self.variables = scene, variables
        self.count = len(scene.columns)
        self.rate = 10.0**scene.log10_rate if any(scene.start[:3]) or scene.body.weight else 1.0
        inertia = [[to_double(x) for x in row] for row in scene.body.inertia]
        self.inertia: Doubles = np.array(inertia)
        self.names = VARIABLES[variables][: self.count]
        self.monomials: list[Monomial] = [
            places
            for degree in range(3)
            for places in combinations_with_replacement(range(self.count), degree)
            if places != (5, 5)  # gamma3^2 is 1 - gamma1^2 - gamma2^2
        ]
        first = np.ones(3) * self.rate
        if variables == "momentum":
            first = np.abs(self.inertia) @ first
        self.units: Doubles = np.concatenate([first, np.ones(3)])[: self.count]
        self.states = self._states()
        self.sizes = self._sizes()
        rates = np.array([self._rates(f, 0.0, y) for y in self.states])
        self.own, self.residual = self._coefficients(rates)
        later = np.array([self._rates(f, 1.0 / self.rate, y) for y in self.states[:_LATER]])
        moved = np.abs(later - rates[:_LATER]) / self.sizes
        largest = np.abs(rates / self.sizes)  # more than 1 if f errs, and then it rounds by more
        vectors = [np.max(largest[:, k : k + 3], initial=1.0) for k in range(0, self.count, 3)]
        self.noise = max(_ROUNDING, _NOISE * self.residual) * np.repeat(vectors, 3)
        self.depends_on_time = bool(np.any(moved > self.noise))
        self.right = self._of(scene)

    def _states(self) -> Doubles:
        """States of the body, the same each time, as rows."""
        random = np.random.default_rng(60)
        omega = random.uniform(-1, 1, (_STATES, 3)) * self.rate
        first = omega if self.variables == "omega" else omega @ self.inertia
        gamma = random.normal(size=(_STATES, 3))
        gamma /= np.linalg.norm(gamma, axis=1, keepdims=True)
        return np.hstack([first, gamma])[:, : self.count]

    def _sizes(self) -> Doubles:
        """The most that each rate may be, without cancellation."""
        body = self.scene.body
        inertia, ones = np.abs(self.inertia), np.ones(3)
        arm = np.array([abs(to_double(x)) for x in body.torque])
        momentum = inertia @ ones * self.rate
        torque = _largest_product(ones * self.rate, momentum) + _largest_product(ones, arm)
        first = (
            torque if self.variables == "momentum" else np.abs(np.linalg.inv(self.inertia)) @ torque
        )
        sizes = np.concatenate([first, 2 * self.rate * ones])[: self.count]
        nonzero: Doubles = np.where(sizes > 0, sizes, 1.0)
        return nonzero

    def _rates(self, f: Field, t: float, y: Doubles) -> Doubles:
        """The rates at a state; raises BadInput."""
        expected = f"{self.count} finite numbers, the rates of {' '.join(self.names)}"
        try:
            rates = np.asarray(f(t, y.copy()), dtype=float)
        except (TypeError, ValueError, IndexError) as fault:
            raise BadInput("compare_field", "f(t, y)", None, f"{expected} ({fault})") from fault
        if rates.shape != (self.count,) or not np.all(np.isfinite(rates)):
            raise BadInput("compare_field", "f(t, y)", rates.tolist(), expected)
        return rates

    def _coefficients(self, rates: Doubles) -> tuple[Doubles, float]:
        """Coefficients of the monomials in each rate, shape (rates, monomials), each as the most
        that it adds; and what is left of the largest rate."""
        scaled = self.states / self.units
        matrix = np.array([[math.prod(y[k] for k in m) for m in self.monomials] for y in scaled])
        coefficients, *_ = np.linalg.lstsq(matrix, rates / self.sizes, rcond=None)
        left = float(np.max(np.abs(matrix @ coefficients - rates / self.sizes)))
        return coefficients.T, left / max(1.0, float(np.max(np.abs(rates / self.sizes))))

    def _of(self, scene: Scene) -> Doubles:
        """The coefficients of a scene's equations."""
        plain = field(scene)
        inertia = np.array([[to_double(x) for x in row] for row in scene.body.inertia])

        def of_momentum(t: float, y: Doubles) -> Doubles:
            rates = plain(t, np.concatenate([np.linalg.solve(inertia, y[:3]), y[3:]]))
            return np.concatenate([inertia @ rates[:3], rates[3:]])

        f = plain if self.variables == "omega" else of_momentum
        return self._coefficients(np.array([self._rates(f, 0.0, y) for y in self.states]))[0]

    def comparison(self) -> FieldComparison:
        """What differs."""
        differences: tuple[Difference, ...] = ()
        on_time = ["f depends on t"] if self.depends_on_time else []
        if self.residual >= _MOST:
            (fault,) = on_time or [f"f is no polynomial of degree two in {' '.join(self.names)}"]
            terms = [f"{fault}: {self.residual:.1g} of its rates is left beside one"]
        else:
            differences = self._differences(self.own, self.right)
            terms = [*self._terms(), *on_time]
        return FieldComparison(self.scene, self.variables, differences, tuple(terms), self.residual)

    def _differences(self, own: Doubles, right: Doubles) -> tuple[Difference, ...]:
        """The coefficients that differ, as they stand in f."""
        differences = []
        for row, column in np.argwhere(self._differ(own, right)).tolist():
            places = self.monomials[column]
            unit = self.sizes[row] / math.prod(self.units[k] for k in places)
            true, coefficient = float(right[row, column]), float(own[row, column])
            true = 0.0 if abs(true) <= _ROUNDING else true * unit
            coefficient = 0.0 if abs(coefficient) <= self.noise[row] else coefficient * unit
            term = " ".join(self.names[k] for k in places) or "1"
            differences.append(Difference(f"{self.names[row]}'", term, true, coefficient))
        return tuple(differences)

    def _terms(self) -> Iterator[str]:
        """What differs, in words: whole terms, and the coefficients of others."""
        if not np.any(self._differ(self.own, self.right)):
            return
        for words, scene in self._others():
            if not np.any(self._differ(self.own, self._of(scene))):
                yield f"the equations are those of a body with {words}"
                return
        left = self.own.copy()
        for words, rows, columns in self._vectors():
            place = np.ix_(rows, columns)
            own, right = self.own[place], self.right[place]
            if not np.any(self._differ(own, right, rows)):
                continue
            ratio = float(np.sum(own * right) / (np.sum(right * right) or 1.0))
            if np.all(np.abs(own) <= self.noise[rows, None]):
                ratio = 0.0
            shown = bool(np.any(np.abs(right) > _ROUNDING))
            multiple = shown and not np.any(self._differ(own, ratio * right, rows))
            plain = multiple and _name_of_ratio(ratio) is not None
            if shown and not plain and self._is_undivided(own, right, rows):
                yield f"{words} is not divided by the moments: I^-1 is missing"
            elif multiple:
                yield f"{words} {_ratio(ratio)}"
            else:
                continue
            left[place] = right
        yield from map(str, self._differences(left, self.right))

    def _differ(
        self, own: Doubles, right: Doubles, rows: Sequence[int] | slice = slice(None)
    ) -> npt.NDArray[np.bool_]:
        """Which coefficients of these rates differ, by more than rounding."""
        noise = self.noise[rows, None]
        differ: npt.NDArray[np.bool_] = np.abs(own - right) > noise + _LEAST * np.abs(right)
        return differ

    def _is_undivided(self, own: Doubles, right: Doubles, rows: Sequence[int]) -> bool:
        """Whether a term of omega's rates is the torque itself."""
        if self.variables == "momentum" or rows[0] >= 3:
            return False
        sizes = self.sizes[:3, None]
        undivided = self.inertia @ (right * sizes) / sizes
        return not np.any(self._differ(own, undivided, rows))

    def _vectors(self) -> Iterator[tuple[str, list[int], list[int]]]:
        """The terms of the equations: their words, the rates and the monomials."""
        kinds = [tuple(k >= 3 for k in places) for places in self.monomials]

        def of(kind: tuple[bool, ...]) -> list[int]:
            return [k for k, own in enumerate(kinds) if own == kind]

        gyroscopic = {"omega": "-omega x I omega", "momentum": "G x omega"}[self.variables]
        yield f"the gyroscopic term {gyroscopic}", [0, 1, 2], of((False, False))
        if self.count > 3:
            yield "the torque Mg gamma x r0", [0, 1, 2], of((True,))
            yield "gamma' = gamma x omega", [3, 4, 5], of((False, True))

    def _others(self) -> Iterator[tuple[str, Scene]]:
        """Bodies that may be meant, in words."""
        for hypothesis in other_scenes(self.scene):
            scene, _ = hypothesis.of(Fraction(0))
            if scene.body.inertia != self.scene.body.inertia:  # the weight is a term of its own
                yield hypothesis.words, scene
        inertia = self.scene.body.inertia
        full = any(inertia[i][j] for i in range(3) for j in range(i))
        for order in permutations(range(3)):
            x, y, z = (exact_vector([inertia[i][j] for j in order]) for i in order)
            if (x, y, z) != inertia:
                names = " ".join(("x y z" if full else "A B C").split()[k] for k in order)
                words = f"an inertia whose axes x y z are {names} of the scene's"
                if not full:
                    words = f"the moments A B C = {names} of the scene"
                body = self.scene.body.replaced(inertia=(x, y, z))
                yield words, replace(self.scene, body=body)


def _name_of_ratio(ratio: float) -> str | None:
    """What a term is that is so many times the right one, where that has a name."""
    return next((name for x, name in _PLAIN.items() if abs(ratio - x) <= _NEAR * abs(x)), None)


def _ratio(ratio: float) -> str:
    """What a term is that is so many times the right one."""
    return _name_of_ratio(ratio) or f"is {ratio:.6g} times the right one"


def _largest_product(a: Doubles, b: Doubles) -> Any:
    """The most that components of a vector product may be, of vectors that are at most so large."""
    return np.roll(a, -1) * np.roll(b, 1) + np.roll(a, 1) * np.roll(b, -1)
