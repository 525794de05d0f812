"""Arguments given in Python: what they must be, checked in one place; raises BadInput."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Set
from contextlib import nullcontext, suppress
from fractions import Fraction
from functools import wraps
from operator import index
from typing import TYPE_CHECKING, Any, TypeVar, cast

from polhode.common.errors import BadInput, listed, plain
from polhode.common.interrupts import bar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

T = TypeVar("T")
Function = TypeVar("Function", bound=Callable[..., object])

_LONG = 2.0**53  # whole numbers that a double may not hold
MOST_STEPS = 1 << 62  # heyoka counts in 64 bits


def whole(source: str, key: str, value: Any, least: int, most: int | None = None) -> int:
    """A whole number of any kind, numpy's too, between bounds; no bool, no float."""
    expected = f"a whole number, {least} " + ("or more" if most is None else f"to {most}")
    with suppress(TypeError):  # of a value that is no whole number
        number = index(value)
        is_truth = type(value).__name__ in ("bool", "bool_")
        if not is_truth and number >= least and (most is None or number <= most):
            return number
    raise BadInput(source, key, value, expected)


def cells(source: str, value: Any, most: int) -> tuple[int, int]:
    """The cells of a grid, ``(rows, columns)``: two whole numbers from 1, ``most`` cells in all."""
    try:
        first, second = value
    except (TypeError, ValueError):
        raise BadInput(source, "grid", value, "two whole numbers") from None
    rows, columns = (whole(source, "grid", n, 1, most) for n in (first, second))
    if rows * columns > most:
        raise BadInput(source, "grid", f"{rows}x{columns}", f"at most {most} cells in all")
    return rows, columns


def rows_of(
    source: str, key: str, values: Any, width: int, kind: npt.DTypeLike | None = None
) -> npt.NDArray[Any]:
    """An array (n, width) of finite floats: float64, or longdouble where it is one; or ``kind``.

    Narrower numbers are converted; those that would be changed, wider and masked ones are refused,
    with the first row that is at fault.
    """
    import numpy as np

    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != width:
        shape = f"an array of shape {array.shape}"
        raise BadInput(source, key, shape, f"shape (N, {width})")
    wide = array.dtype.kind == "f" and array.dtype.itemsize > 8  # where longdoubles are wider
    into = np.dtype(kind or (np.longdouble if wide else np.float64))
    if array.dtype.kind not in "fiu" or not np.can_cast(array.dtype, into, "safe"):
        raise BadInput(source, key, f"numbers of {array.dtype}", f"{into} or narrower")
    rows = np.ascontiguousarray(array, dtype=into)
    finite = np.isfinite(rows)
    if array is values and array.dtype.kind == "f" and finite.all():
        return rows
    wrong = ~finite | not_taken(values, rows)
    if wrong.any():
        k = int(np.argmax(wrong.any(axis=1)))
        row = values[k] if isinstance(values, (list, tuple)) else array[k]
        row = row.tolist() if isinstance(row, np.ndarray) else row
        expected = f"finite numbers that {into} holds"
        raise BadInput(source, f"{key}, row {k + 1}", plain(row), expected)
    return rows


def not_taken(values: Any, taken_values: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which numbers of an array of floats are not those of the values that it was made of.

    Masked ones, also in arrays inside a list; long integers, which numpy rounds silently.
    """
    import numpy as np

    wrong = np.zeros(taken_values.shape, dtype=bool)
    if type(values) is np.ndarray and values.dtype.kind == "f":  # narrower floats stay themselves
        return wrong
    if isinstance(values, (list, tuple)) and taken_values.ndim > 1:
        for k, row in enumerate(values):
            if isinstance(row, np.ma.MaskedArray):
                wrong[k] = np.ma.getmaskarray(row)
    else:
        wrong |= np.ma.getmaskarray(values)
    for place in np.argwhere(np.isfinite(taken_values) & (np.abs(taken_values) >= _LONG)).tolist():
        value: Any = values if isinstance(values, (list, tuple)) else np.asarray(values)
        for k in place:
            value = value[k]
        wrong[tuple(place)] = int(value) != int(taken_values[tuple(place)])
    return wrong


def unit_rows(source: str, key: str, rows: npt.NDArray[Any], eps: Fraction) -> None:
    """Refuse rows that are no unit vectors to 8 eps, by the first of them."""
    import numpy as np

    off, most = np.abs(np.vecdot(rows, rows) - 1), 8 * float(eps)
    if off.max(initial=0.0) <= most / 2:  # rounding here is less than that
        return
    for k in np.flatnonzero(~(off <= most / 2)).tolist():
        if not is_unit(rows[k], eps):
            row = plain(rows[k].tolist())
            raise BadInput(source, f"{key}, row {k + 1}", row, "gamma of length 1, to 8 eps")


def is_unit(vector: Iterable[Any], eps: Fraction) -> bool:
    """Whether the square of a length is 1 to 8 eps, exactly; of floats of any kind."""
    numbers = [*vector]
    if not all(x - x == 0 for x in numbers):  # not finite
        return False
    squares = (Fraction(*x.as_integer_ratio()) ** 2 for x in numbers)
    return abs(sum(squares, Fraction(-1))) <= 8 * eps


def steps(source: str, value: object) -> int:
    """A limit on steps; one beyond what can be counted is none."""
    return min(whole(source, "max_steps", value, 1), MOST_STEPS)


def numbers_given(t: object) -> tuple[list[Any], bool]:
    """What was given as one number or several: a list of them, and whether it was several.

    What has no order, a set or a mapping, is no several numbers: whoever reads it refuses it.
    """
    if isinstance(t, (str, bytes, Set, Mapping)) or not isinstance(t, Iterable):
        return [t], False
    if getattr(t, "ndim", 1) == 0:  # an array of no dimension is a number
        return [t], False
    return list(t), True


def each(
    source: str, key: str, values: object, read: Callable[[Any], T], expected: str
) -> tuple[T, ...]:
    """Each of some values read, such as the times ``at``; what ``read`` refuses is named."""
    listed, several = numbers_given(values)
    if not several:
        raise BadInput(source, key, values, expected)
    elements = []
    for k, value in enumerate(listed):
        try:
            elements.append(read(value))
        except (TypeError, ValueError) as fault:
            raise BadInput(source, f"{key}[{k + 1}]", value, f"a number ({fault})") from None
    return tuple(elements)


#: What other programs call an argument or an option, and what it is called here.
_ELSEWHERE = {
    "tol": ("rtol", "atol", "tolerance", "eps", "epsabs", "epsrel"),
    "at": ("t_eval", "t_span", "t", "times", "ts", "tspan", "saveat"),
    "end": ("t_end", "tmax", "t_max", "until", "duration"),
    "every": ("dt", "step", "interval"),
    "max_steps": ("nsteps", "n_steps", "mxstep", "maxiter", "steps"),
    "digits": ("dps", "precision"),
    "number": ("dtype", "type", "number_type", "prec"),
    "method": ("solver", "integrator"),
    "workers": ("n_jobs", "jobs", "processes", "nworkers", "threads", "parallel"),
    "against": ("scene", "reference", "ref"),
    "o": ("out", "output", "output_file", "file", "save"),
}


def called_here(name: str, candidates: Iterable[str]) -> str | None:
    """The one of the known names that says what a name of other programs does; None without."""
    here = (key for key, names in _ELSEWHERE.items() if name in names)
    return next((key for key in here if key in candidates), None)


def refuse_unknown(
    source: str, function: Callable[..., object], unknown: Mapping[str, object], **meant: str
) -> None:
    """Raise BadInput for arguments that a function has not, with what may be meant.

    ``meant``: what to say of some names.
    """
    for name, value in unknown.items():
        import inspect

        names = [key for key in inspect.signature(function).parameters if key != "unknown"]
        if name in names:
            continue
        here = called_here(name, names)
        expected = f"an argument: {listed(name, names)}"
        if here is not None:
            expected = f"{here}, as it is called here"
        raise BadInput(source, name, plain(value), meant.get(name, expected))


def with_options(options: type) -> Callable[[Function], Function]:
    """Let signature and help of a function with ``**name: Unpack[options]`` spell these out.

    ``options``: a TypedDict; its docstring has them as numpydoc's Parameters, none of which a call
    needs.  The verbs read the same.  Names that are none of them the function refuses itself, by
    :func:`refuse_unknown`.
    """

    def spelled_out(function: Function) -> Function:
        from inspect import Parameter, cleandoc, signature

        written, entries = signature(function), cleandoc(options.__doc__ or "")
        *own, _ = written.parameters.values()
        shared = [
            Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind.__forward_arg__)
            for name, kind in options.__annotations__.items()
        ]
        vars(function)["__signature__"] = written.replace(parameters=[*own, *shared])
        head, returns, tail = cleandoc(function.__doc__ or "").partition("\n\nReturns\n")
        entries = entries.partition("\n----------")[2]
        function.__doc__ = f"{head}{entries}{returns}{tail}"
        return function

    return spelled_out


def with_progress(function: Function) -> Function:
    """Let a function refuse a ``progress`` that cannot be called; raises BadInput.

    False is none.  Where the annotation has ``bool``, True is a bar, called as the function's first
    argument is: inside the function it is never a bool.
    """
    positional = function.__code__.co_varnames[: function.__code__.co_argcount]
    place = positional.index("progress") if "progress" in positional else sys.maxsize
    takes_bool = "bool" in str(function.__annotations__.get("progress"))
    expected = "a function to call" + ", True for a bar, or False" * takes_bool

    @wraps(function)
    def answer(*values: Any, **named: Any) -> object:
        by_place = place < len(values)
        progress = values[place] if by_place else named.get("progress")
        if progress is None or callable(progress):
            return function(*values, **named)
        if progress is not False and not (takes_bool and progress is True):
            raise BadInput(function.__name__, "progress", plain(progress), expected)
        first = values[0] if values else named.get("scene")
        with bar(str(getattr(first, "name", first))) if progress else nullcontext() as tell:
            if by_place:
                values = (*values[:place], tell, *values[place + 1 :])
            else:
                named["progress"] = tell
            return function(*values, **named)

    return cast("Function", answer)


def of_kind(
    source: str, key: str, value: object, kinds: type | tuple[type, ...], expected: str
) -> None:
    """Refuse a value that is of none of some classes."""
    if not isinstance(value, kinds):
        raise BadInput(source, key, value, expected)
