"""The members of a sweep, integrated: their states, and how each ended."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import JobCheckpoint
from polhode.common.errors import BadInput, counted
from polhode.common.values import ByValue, cached_property, may_wait
from polhode.equations import integrals
from polhode.equations.columns import derived_stack, of_state_alone
from polhode.motion.frame import Frame
from polhode.motion.outcomes import OUTCOMES, Outcome
from polhode.numbers import number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import shown
from polhode.numbers.double_double import Pairs, sqrt
from polhode.numbers.number_types import Booleans, Doubles, Flat, Indices, NumberType, Rows, Stack
from polhode.results.cells import DOUBLE, EXACT, lines
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.members import Block, ColumnVector, Members, paired
from polhode.runs.options import Options
from polhode.runs.trajectory import ERROR, Trajectory, solve
from polhode.scenes import vary
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import (
    provenance_fact,
    row_columns,
    scene_facts,
    text_column,
    time_column,
    varied_columns,
)
from polhode.scenes.vocabulary import ATTITUDE, COLUMNS

# --- endings --------------------------------------------------------------------------------------
#
# How the members of a sweep ended, all together.


class SweepResult(Result, ByValue):
    """Members of a sweep, each of which ended in some way.

    ``endings``: how, indices into :data:`polhode.motion.outcomes.OUTCOMES`.
    """

    endings: npt.NDArray[np.uint8]

    def tally(self) -> dict[Outcome, int]:
        """How many members ended how, in the order in which the first of each comes."""
        codes, first, counts = np.unique(self.endings, return_index=True, return_counts=True)
        return {OUTCOMES[codes[k]]: int(counts[k]) for k in np.argsort(first)}

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C left members undone."""
        return Outcome.NOT_RUN in self.tally()

    @property
    def complete(self) -> bool:
        """Whether every member reached the end."""
        return all(outcome.done for outcome in self.tally())

    def _reached(self) -> str:
        """How many members reached the end, in words."""
        count = sum(n for outcome, n in self.tally().items() if outcome.done)
        return "all reached the end" if self.complete else f"{count} of them reached the end"


# --- drift ----------------------------------------------------------------------------------------
#
# Drift of the first integrals of all members of a sweep at once.
#
# What :func:`polhode.equations.integrals.drift` is for one trajectory: relative departures from
# the exact member's values. In pairs of doubles (:mod:`polhode.numbers.double_double`), which
# hold far more than the states do.


_IN_ARRAYS = integrals.Choices(np.sqrt, np.maximum, np.where)
_NO_AREA = 2.0**-80  # of the terms of f, which may then be zero


@np.errstate(all="ignore")
def drifts(members: Members, states: Stack, drift_of: Callable[[int], integrals.Drift]) -> Doubles:
    """Largest drift of h, f, |gamma|² and the fourth of each member, shape (members, 4).

    nan where there is none, or the member has no state.  ``states``: (members, times, columns);
    ``drift_of``: a member that the columns do not hold.
    """
    drift = np.full((len(members), 4), np.nan)
    there = states[:, :, 0] == states[:, :, 0]
    turned = states.dtype == object or not members.scene.body.axes.trivial
    for block in members.blocks():
        alone = block.doubt | turned
        for which in _alike(block, alone):
            at = block.first + which
            member = members[int(at[0])]
            known = integrals.first_integrals(Frame.of(member).inside(member))
            rows = _block_drifts(known, block, which, states[at], there[at], members.gammas is None)
            drift[at, : rows.shape[1]] = rows
        for k in block.first + np.flatnonzero(alone):
            if there[k].any():
                drift[k] = [np.nan if x is None else x for x in drift_of(int(k))]
    if states.shape[2] == 3:  # h and, if there is one, the fourth
        drift[:, 3] = np.where(np.isnan(drift[:, 3]), drift[:, 1], drift[:, 3])
        drift[:, 1] = np.nan
    return drift


def _alike(block: Block, alone: Booleans) -> list[Indices]:
    """The members in sets whose bodies are classical tops of one kind and axis.

    Without those that are ``alone``, among which are then all whose f may be zero or not.
    """
    if alone.all():
        return []
    moments, torque, omega = (
        [*map(paired, vector)] for vector in (block.moments, block.torque, block.omega)
    )
    tests = [x.hi == 0 for x in torque]
    a, b, c = moments
    for x, y in ((a, b), (b, c), (c, a)):
        tests.append((x - y).hi == 0)
        tests += [(n * s - t).hi == 0 for n in (2, 4) for s, t in ((x, y), (y, x))]
    if block.gamma is not None:
        terms = [i * w * paired(g) for i, w, g in zip(moments, omega, block.gamma, strict=True)]
        area = np.abs((terms[0] + terms[1] + terms[2]).hi)
        tests.append(area == 0)
        if np.ndim(area):
            size = sum(np.abs(x.hi) for x in terms)
            alone |= (area != 0) & (area < _NO_AREA * size)
    bits = np.stack(np.broadcast_arrays(alone, *tests), axis=1)
    members = np.flatnonzero(~alone)
    if not len(members):
        return []
    _, kind = np.unique(np.packbits(bits[members], axis=1), axis=0, return_inverse=True)
    return [members[kind.ravel() == n] for n in range(int(kind.max()) + 1)]


def _block_drifts(
    known: integrals.FirstIntegrals,
    block: Block,
    which: Indices,
    states: Stack,
    there: Booleans,
    unit: bool,
) -> Doubles:
    """The drifts of members that have the same integrals, columns in the integrals' order.

    ``unit``: whether gamma is of length 1; else it is divided by its length, as exact members are.
    """
    moments, torque, omega = (_pairs(x, which) for x in (block.moments, block.torque, block.omega))
    gamma = [] if block.gamma is None else _pairs(block.gamma, which)
    if not unit:
        length = sqrt(gamma[0] * gamma[0] + gamma[1] * gamma[1] + gamma[2] * gamma[2])
        gamma = [g / length for g in gamma]
    k = integrals.coefficients(
        moments, torque, _largest(moments), known.onto[-1], known.order, sqrt
    )
    start = known.values([*omega, *gamma], k, Pairs(0.0))
    columns = [paired(states[:, :, i]) for i in range(states.shape[2])]
    values = known.values(columns, k, Pairs(0.0))
    high = {name: x.hi for name, x in k.items()}
    a, b, c = ([x.hi for x in vector] for vector in (moments, torque, omega))
    scales = integrals.measures(known, high, a, b, c, _IN_ARRAYS)
    drift = [
        np.where(there, np.abs((value - target).hi) / measure, -np.inf).max(axis=1)
        for value, target, measure in zip(values, start, scales, strict=True)
    ]
    rows = np.stack(drift, axis=1)
    rows[~there.any(axis=1)] = np.nan
    return rows


def _pairs(vector: ColumnVector, which: Indices) -> list[Pairs]:
    """Three columns' numbers of some members, shape (members, 1)."""
    columns = map(paired, vector)
    return [
        x if np.ndim(x.hi) == 0 else Pairs(x.hi[which, None], x.lo[which, None]) for x in columns
    ]


def _largest(values: list[Pairs]) -> Pairs:
    best = values[0]
    for x in values[1:]:
        more = (x - best).hi > 0
        best = Pairs(np.where(more, x.hi, best.hi), np.where(more, x.lo, best.lo))
    return best


# --- ensemble -------------------------------------------------------------------------------------


def no_states(number: NumberType, shape: tuple[int, ...]) -> Stack:
    """States of this shape, none of them a number."""
    if number.flat:
        return number_types.flat(np.full(shape, np.nan, number_types.kind_of(number)))
    from polhode.numbers.mpmath_context import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


_SHOWN = 20  # members at either end of a long sweep, in text


@may_wait("provenance")
@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(SweepResult):
    """Members of a sweep at the same output times, states in the scene's body axes.

    >>> import polhode
    >>> many = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:3"}, at=[0, 1])
    >>> many
    <Ensemble of lagrange/nutation: 3 members in double, 2 times to t = 1, all reached the end>
    >>> many.states.shape, many.t.tolist(), many[2].outcome.value
    ((3, 2, 6), [0.0, 1.0], 'reached end')

    ``varied``: keys and exact values, one row per member.  ``states``: shape (members, times,
    columns), columns p q r [gamma1 gamma2 gamma3] in the scene's units; float64, longdouble, or
    objects (mpf) in wider types; nan at times that a member did not reach.  ``outcomes``,
    ``steps``, ``reached``, ``errors``: one for each member, made of the arrays ``endings``,
    ``counts``, ``arrived`` and of ``estimates`` when asked for.  ``ensemble[k]`` is member k as a
    Trajectory, and iteration gives all of them.  ``projected``: False, the states are not projected
    onto the first integrals.  ``kept``: the folder in which finished members were kept.
    """

    scene: Scene
    varied: vary.Variation
    members: Members
    number: NumberType
    times: tuple[Fraction, ...]
    states: Stack
    endings: npt.NDArray[np.uint8]  # indices into polhode.motion.outcomes.OUTCOMES
    counts: npt.NDArray[np.int64]  # of steps
    arrived: Stack  # times reached, Fractions
    tolerance: float
    digits: int | None = None
    projected: bool = False
    estimates: Mapping[int, tuple[float | None, ...]] = field(default_factory=dict)
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)
    kept: JobCheckpoint | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        for array in (self.states, self.endings, self.counts, self.arrived):
            array.flags.writeable = False

    def __setstate__(self, state: Mapping[str, object]) -> None:
        super().__setstate__(state)
        self.__post_init__()

    def __len__(self) -> int:
        return len(self.members)

    def __repr__(self) -> str:
        members = counted(len(self), "member")
        return (
            f"<Ensemble of {self.scene.name}: {members} in {self.number.name}, "
            f"{counted(len(self.times), 'time')} to t = {shown(self.times[-1])}, {self._reached()}>"
        )

    def __str__(self) -> str:
        """One line per member: what is varied, how it ended, its last state.

        Of many members the first and last ones, and how many are between them.
        """
        count = len(self)
        between = count - 2 * _SHOWN if count > 3 * _SHOWN else 0
        member = np.delete(np.arange(count), slice(_SHOWN, _SHOWN + between))
        there = self.states[member, :, 0]
        last = (there == there).sum(axis=1) - 1
        scene, place = self.scene, np.maximum(last, 0)
        t = time_column(scene, self.times, self.number)
        columns = [
            Column("member", member + 1),
            *varied_columns(self.varied, member),
            text_column("outcome", [self.outcome(k).value for k in member.tolist()]),
            Column("steps", self.counts[member]),
            t._replace(values=[None if k < 0 else t.values[k] for k in last.tolist()]),
            *row_columns(scene, scene.columns, self.states[member, place], self.number),
        ]
        for word, rows in self.outputs.items():
            columns += row_columns(scene, COLUMNS[word].names, rows[member, place], self.number)
        text = lines(Table(columns))
        if between:
            text.insert(
                1 + _SHOWN, f"... {between} more of {count} members: a file (-o) has all ..."
            )
        return "\n".join(text)

    def __iter__(self) -> Iterator[Trajectory]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, index: int) -> Trajectory:
        """One member by itself, as far as it came; raises TypeError for a slice."""
        index = operator.index(index)
        member = self.members[index]
        states = self.rows(index)
        count = len(states)
        if self.outputs:
            member = replace(member, outputs=tuple(self.outputs))
        return Trajectory(
            scene=member.at(self.scene.times),
            number=self.number,
            times=self.times[:count],
            states=number_types.read_only(states, len(member.columns)),
            outcome=self.outcome(index),
            steps=int(self.counts[index]),
            reached=self.arrived[index],
            tolerance=self.tolerance,
            digits=self.digits,
            provenance=self.provenance,
            method="taylor" if self._errors(index) is None else "refined",
            errors=self._errors(index),
        )

    @property
    def t(self) -> npt.NDArray[np.float64]:
        """The times as doubles, the nearest ones."""
        return np.array([to_double(t) for t in self.times])

    def _errors(self, index: int) -> tuple[float | None, ...] | None:
        return self.estimates.get(index % len(self))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the states' columns."""
        return self.scene.columns

    @cached_property
    def outputs(self) -> Mapping[str, Stack]:
        """Outputs of the scene that are made of the states alone, (members, times, columns).

        Others are left out of a sweep, see :attr:`attitude`.  nan at times that a member did not
        reach.
        """
        words = [word for word in of_state_alone() if word in self.scene.outputs]
        stacks = {
            word: derived_stack(word, self.members, self.states, self.number) for word in words
        }
        for stack in stacks.values():
            stack.flags.writeable = False
        return stacks

    @cached_property
    def attitude(self) -> Stack:
        """Unit quaternions from body axes to space, scalar first, shape (members, times, 4).

        A sweep does not follow them: each member is run once more, by itself and not projected,
        when they are first asked for.  nan at times that a member did not reach.  Raises BadInput
        for a scene without gamma.
        """
        if self.scene.gamma is None:
            raise BadInput(self.scene.name, "attitude", None, "a start with gamma")
        shape = (len(self), len(self.times), len(ATTITUDE))
        quaternions = no_states(self.number, shape)
        usual = self.tolerance == float(self.number.eps)
        tolerance = None if usual else Fraction(self.tolerance)
        for k, member in enumerate(self.members):
            scene = replace(
                member, times=self.scene.times[: len(self.rows(k))], outputs=("attitude",)
            )
            if scene.times:
                options = Options("taylor", None, False, tolerance)
                run = solve(scene, self.number, options, interruptible=False)
                quaternions[k, : len(run.times)] = run.attitude
        quaternions.flags.writeable = False
        return quaternions

    @cached_property
    def outcomes(self) -> tuple[Outcome, ...]:
        """How each member ended."""
        return tuple(OUTCOMES[code] for code in self.endings.tolist())

    def outcome(self, index: int) -> Outcome:
        """How one member ended."""
        return OUTCOMES[int(self.endings[index])]

    @cached_property
    def steps(self) -> tuple[int, ...]:
        """How many steps each member took."""
        return tuple(self.counts.tolist())

    @cached_property
    def reached(self) -> tuple[Fraction, ...]:
        """The time that each member reached."""
        return tuple(self.arrived.tolist())

    @cached_property
    def errors(self) -> tuple[tuple[float | None, ...] | None, ...]:
        """One entry per member: of a refined one what a refined trajectory's are, else None."""
        return tuple(self.estimates.get(k) for k in range(len(self)))

    @cached_property
    def drift(self) -> npt.NDArray[np.float64]:
        """Largest drift of h, f, |gamma|² and the fourth integral of each, shape (members, 4).

        From the member's exact scene, see :class:`polhode.equations.integrals.Drift`; nan where
        unknown.
        """
        drift = drifts(self.members, self.states, lambda k: self[k].drift)
        drift.flags.writeable = False
        return drift

    def table(self) -> Table:
        """One row per member and time that it reached: what is varied, t, the state, outputs."""
        there = self.states[:, :, 0] == self.states[:, :, 0]
        member, time = np.nonzero(there)
        scene, number = self.scene, self.number
        t = time_column(scene, self.times, number)
        columns = [
            Column("member", member + 1),
            t._replace(values=[t.values[k] for k in time.tolist()]),
            *varied_columns(self.varied, member),
            *row_columns(scene, scene.columns, self.states[there], number),
        ]
        for word, rows in self.outputs.items():
            columns += row_columns(scene, COLUMNS[word].names, rows[there], number)
        if self.estimates:
            pairs = zip(member.tolist(), time.tolist(), strict=True)
            errors = [None if (own := self.estimates.get(m)) is None else own[k] for m, k in pairs]
            columns.append(Column("error", errors, ERROR, type=DOUBLE, digits=2))
        return Table(columns, 2)

    def facts(self) -> list[Fact]:
        """What was varied, how the members were integrated, and how each ended."""
        return [
            *scene_facts(self.scene, times=self.times),
            Fact("vary", list(self.varied.keys), "what is varied"),
            Fact("number", self.number.name, "the type of the numbers"),
            Fact("bits", self.number.bits, "of its significand"),
            Fact("digits", self.digits, "correct digits asked for"),
            Fact("form", self.scene.form, "of the equations"),
            Fact("tolerance", self.tolerance, "of a step, relative"),
            Fact("projected", self.projected, "whether put back on the first integrals"),
            Fact("complete", self.complete, "whether every member reached the end"),
            Fact("members", self._members()),
            provenance_fact(self.provenance),
        ]

    def _members(self) -> Table:
        member = np.arange(len(self))
        drift = (
            Column(f"drift_{name}", self.drift[:, k], "largest departure of an integral, relative")
            for k, name in enumerate(integrals.Drift._fields)
        )
        return Table(
            [
                Column("member", member + 1),
                *varied_columns(self.varied, member),
                text_column("outcome", [x.value for x in self.outcomes]),
                Column("reached", list(self.reached), "the time reached", type=EXACT),
                Column("steps", self.counts),
                *drift,
            ]
        )

    def rows(self, index: int) -> Rows:
        """The states of one member at the times that it reached."""
        states = self.states[index]
        found: Flat = states[: int((states[:, 0] == states[:, 0]).sum())]
        return found if self.number.flat else found.tolist()
