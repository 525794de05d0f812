"""Attitudes in panels: the closed form's at some, carried to those between by the turns.

In panel i, q(t) = c_i ∘ turn_i(t); where two panels touch, at t = s,

    c_{i+1} = c_i ∘ turn_i(s) ∘ turn_{i+1}(s)*.

The closed form is asked for c at every so many panels and at the ends where no panel follows:
what was carried so far must be the same there.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from polhode.closed_forms.functions.quaternion import conjugate, product
from polhode.judging._dense_reference.parallel_evaluation import Ask
from polhode.judging._dense_reference.taylor_panels import (
    SPARE,
    NotSo,
    Numbers,
    Panels,
    at_doubles,
    in_columns,
)
from polhode.judging._dense_reference.taylor_series import stacked
from polhode.judging.references.reference import rows
from polhode.numbers.double_double import Pairs
from polhode.numbers.rows import Doubles

_EVERY = 16  # panels


class Attitudes:
    """q in panels; raises NotSo where the closed form's answers do not fit each other.

    ``held``: ascending times that the panels are for; ``ask``: the closed form's attitude.
    ``begun``: c of each panel, shape (4, panels).
    """

    def __init__(self, panels: Panels, held: Doubles, digits: int, ask: Ask) -> None:
        joints, touch = panels.joints
        every = np.arange(len(panels.middles))
        first = np.nonzero(np.concatenate([[True], ~touch]))[0]  # of the panels that touch
        since = every - first[np.searchsorted(first, every, "right") - 1]
        asked = np.nonzero(since % _EVERY == 0)[0]
        of, edges = panels.edges(held)
        moments = np.concatenate([panels.middles[asked], edges])
        true = in_columns(rows(ask, [Fraction(t) for t in moments.tolist()], digits + SPARE))

        steps = every[:-1]
        here, there = (panels.summed(steps + k, at_doubles(joints))[-4:] for k in (0, 1))
        onward = _product(here, _back(there))
        begun = self.begun = Pairs(*np.zeros((2, 4, len(every))))
        _put(begun, asked, true[:, : len(asked)])
        for k in range(1, _EVERY):
            to = (asked + k)[: np.searchsorted(asked + k, len(every))]
            to = to[since[to] % _EVERY == k]
            _put(begun, to, _product(begun[:, to - 1], onward[:, to - 1]))
        again = asked[since[asked] > 0]
        carried = _product(begun[:, again - 1], onward[:, again - 1])
        ends = self.at(of, panels.summed(of, at_doubles(edges)))
        for departure in carried - begun[:, again], ends - true[:, len(asked) :]:
            if not np.all(np.abs(departure.hi) <= 10.0**-digits):
                raise NotSo

    def at(self, of: Numbers, summed: Pairs) -> Pairs:
        """Quaternions in some panels, shape (4, times), from what their series are there."""
        return _product(self.begun[:, of], summed[-4:])


def _product(a: Pairs, b: Pairs) -> Pairs:
    parts = product((a[0], a[1], a[2], a[3]), (b[0], b[1], b[2], b[3]))
    return stacked(parts)


def _back(a: Pairs) -> Pairs:
    return stacked(conjugate((a[0], a[1], a[2], a[3])))


def _put(target: Pairs, at: Numbers, values: Pairs) -> None:
    target.hi[:, at], target.lo[:, at] = values.hi, values.lo
