"""Golden rows: what polhode gives at one state of the code, by the doors that users have.

    python tests/measure/golden.py make OUT.json.gz [--part NAME ...] [--workers N]
    python tests/measure/golden.py diff A.json.gz B.json.gz
    python tests/measure/golden.py check [--part NAME ...]        tests/data/golden.json.gz and now

``make`` writes the record of every part, each made in a process of its own, N at a time (2).  An
entry is a function without arguments; the refusal of one that is refused is its value.  Numbers are
exact texts (``0x3p-1`` is 3/2), so that a record holds every bit.  ``diff`` lists the entries that
differ, and by how many units of the last place; it ends with 1 if any does.

Nothing here names a module inside polhode: the same file asks the code before and after a change.
Last bits of doubles differ between processors (vector units, mathematical functions), which is why
the record names the one that made it: compare states on one processor to the bit, and elsewhere by
the units of the last place that ``diff`` prints.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import gzip
import io
import json
import math
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import polhode
from polhode.cli import main as command_line

TOP = Path(__file__).parents[2]
ROWS = TOP / "tests/data/golden.json.gz"
CASES = sorted(
    path.relative_to(TOP / "cases").with_suffix("").as_posix()
    for path in (TOP / "cases").rglob("*.toml")
)
Entry = Callable[[], Any]
Entries = Iterator[tuple[str, Entry]]

# --- exact texts of numbers


def text_of(value: Any) -> Any:
    """A value as JSON: containers, words, and every real number as exact text."""
    if value is None or isinstance(value, str):
        return value
    if type(value).__name__ in ("bool", "bool_"):
        return bool(value)
    if isinstance(value, Mapping):
        return {str(key): text_of(one) for key, one in value.items()}
    if hasattr(value, "_asdict"):
        return text_of(value._asdict())
    if isinstance(value, complex):
        return [text_of(value.real), text_of(value.imag)]
    if hasattr(value, "tolist") and getattr(value, "shape", ()):
        return [text_of(one) for one in value]  # by element: tolist would round long doubles
    if isinstance(value, Sequence) or type(value).__name__ in ("set", "frozenset"):
        return [text_of(one) for one in value]
    if hasattr(value, "_mpf_"):
        return str(value) if value - value != 0 else _of_mantissa(value._mpf_)
    if hasattr(value, "value") and isinstance(value.value, str):  # a member of an enumeration
        return value.value
    if isinstance(value, int) or hasattr(value, "__index__"):
        return str(int(value))
    if isinstance(value, Fraction):
        return _of_fraction(value)
    if hasattr(value, "as_integer_ratio"):
        if value - value != 0:
            return str(float(value))  # inf, nan
        if value == 0:
            return "-0x0p+0" if math.copysign(1, value) < 0 else "0x0p+0"
        return _of_fraction(Fraction(*map(int, value.as_integer_ratio())))
    return str(value)


def _of_mantissa(number: tuple[int, Any, Any, int]) -> str:
    """A finite number as mpmath keeps it."""
    sign, mantissa, exponent, _ = number
    return _of_fraction(Fraction(int(mantissa)) * Fraction(2) ** int(exponent) * (-1) ** sign)


def _of_fraction(value: Fraction) -> str:
    """Binary where the number ends in base two, a quotient where it does not."""
    bottom = value.denominator
    if bottom & (bottom - 1):
        return f"{value.numerator}/{bottom}"
    mantissa, exponent = abs(value.numerator), 1 - bottom.bit_length()
    if mantissa:
        even = (mantissa & -mantissa).bit_length() - 1
        mantissa, exponent = mantissa >> even, exponent + even
    return f"{'-' if value < 0 else ''}{mantissa:#x}p{exponent:+d}"


_BINARY = re.compile(r"(-?)0x([0-9a-f]+)p([+-]\d+)")
_QUOTIENT = re.compile(r"-?\d+/\d+")


def number_of(text: object) -> Fraction | None:
    """The number of a text that :func:`text_of` wrote; None for any other."""
    if not isinstance(text, str):
        return None
    if match := _BINARY.fullmatch(text):
        sign, mantissa, exponent = match.groups()
        value = int(mantissa, 16) * Fraction(2) ** int(exponent)
        return -value if sign else value
    return Fraction(text) if _QUOTIENT.fullmatch(text) else None


def attributes(value: Any, names: str) -> dict[str, Any] | None:
    """Some attributes of a value, by name."""
    return None if value is None else {name: getattr(value, name) for name in names.split()}


def answer(entry: Entry) -> Any:
    """What an entry gives, or the class and message of its refusal."""
    try:
        return text_of(entry())
    except Exception as fault:
        return {"refused": [type(fault).__name__, str(fault)]}


# --- runs

EVENTS = (
    (polhode.Event("level", "gamma3 - p/10"), polhode.Event("nutation")),
    (polhode.Event("first", "q - r/3", "rising", stop=True),),
    (polhode.Event("late", "gamma1/(2 + gamma2) - t/100", "falling"),),
)
OUTPUTS: tuple[tuple[str, ...], ...] = ((), ("attitude",), ("angles",), ("attitude", "angles"))
LENGTHS = {"double": (12, 180), "extended": (12, 180), "quad": (12,), "mp": (6,)}
SCENES = [CASES[len(CASES) * k // 40] for k in range(40)]


def unit(scene: polhode.Scene) -> Fraction:
    """The time of about a radian of the start's fastest rate, a power of two."""
    try:
        torque = abs(float(scene.body.weight)) * math.hypot(*map(float, scene.body.centre))
        spin = math.hypot(*map(float, scene.omega))
        rate = max(spin, math.sqrt(torque / max(map(float, scene.body.moments))))
    except OverflowError:
        rate = 1.0
    return Fraction(2) ** -round(math.log2(rate)) if 0 < rate < math.inf else Fraction(1)


def run(case: str, k: int, number: str) -> dict[str, Any]:
    """A scene with one set of outputs, or of events, at a third-like and a whole time."""
    scene = polhode.load(case)
    if k % 5 == 4:
        scene = replace(scene, outputs=(), events=EVENTS[k // 5 % len(EVENTS)])
    else:
        scene = replace(scene, outputs=OUTPUTS[k % 5], events=())
    record = {}
    for length in LENGTHS[number]:
        end = unit(scene) * (-length if k % 7 == 6 else length)
        at = [end * Fraction(3, 8), end]
        record[f"{length}"] = answer(partial(_run, scene, number, at, k % 2 == 0))
    return record


def _run(scene: polhode.Scene, number: str, at: list[Fraction], project: bool) -> dict[str, Any]:
    trajectory = polhode.integrate(scene, number, at=at, project=project, max_steps=20_000)
    return {
        "bits": trajectory.number.bits,
        **attributes(trajectory, "times states attitude angles outcome reached method drift"),
        "events": [
            attributes(one, "name times states grazing complete") for one in trajectory.events
        ],
    }


def runs() -> Entries:
    for number in LENGTHS:
        for k, case in enumerate(SCENES):
            yield f"{number} {case}", partial(run, case, k, number)


# --- closed forms

FIFTY_DIGITS = 192  # bits in which last places are counted


def closed_form(case: str, times: Sequence[Any]) -> dict[str, Any]:
    exact = polhode.reference(case)
    record: dict[str, Any] = {**attributes(exact, "kind regime period"), "bits": FIFTY_DIGITS}
    if not exact.is_closed_form:
        return record
    scale = unit(exact.scene)
    for t in times:
        at = [scale * Fraction(t)]
        record[f"t = {t}"] = {
            name: answer(lambda method=method, at=at: method(at, 50))
            for name, method in (
                ("states", exact.at),
                ("attitude", exact.attitude),
                ("angles", exact.angles),
            )
        }
    return record


def closed_forms() -> Entries:
    for case in CASES:
        yield case, partial(closed_form, case, ("1/3", "-13/10", "7"))
    for k in range(12):
        case = CASES[len(CASES) * k // 12]
        yield f"{case} late", partial(closed_form, case, ("1000000",))


# --- verdicts on files

JUDGED = tuple(CASES[len(CASES) * k // 12 + 3] for k in range(12))
COLUMNS = ("t", "p", "q", "r", "gamma1", "gamma2", "gamma3")


def _table(case: str) -> list[list[Any]]:
    scale = unit(polhode.load(case))
    times = [scale * k / 4 for k in range(21)]
    rows = polhode.reference(case).at(times, 20)
    return [[t, *row] for t, row in zip(times, rows, strict=True)]


#: What a program may do to a right table: a name, and the row it makes of a right one.
CHANGES: dict[str, Callable[[list[Any]], list[Any]]] = {
    "nothing": lambda row: row,
    "degrees": lambda row: [row[0], *(x * 180 / math.pi for x in row[1:4]), *row[4:]],
    "downward": lambda row: [*row[:4], *(-x for x in row[4:])],
    "late clock": lambda row: [row[0] + Fraction(1, 1000), *row[1:]],
    "drift": lambda row: [row[0], *(x * (1 + Fraction(row[0]) / 1000) for x in row[1:4]), *row[4:]],
}


def verdict(case: str, change: str) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "table.csv"
        with file.open("w", newline="") as out:
            writer = csv.writer(out)
            writer.writerow(COLUMNS)
            for row in _table(case):
                writer.writerow([f"{float(x):.17g}" for x in CHANGES[change](row)])
        judgement = _json("compare", str(file), case)
    found = judgement["columns"]["correct_digits"]
    digits = [None if x is None else round(round(x, 2), 1) for x in found]  # as they were recorded
    return {"reading": judgement["reading"], "limit": judgement["limit"], "digits": str(digits)}


def verdicts() -> Entries:
    for case in JUDGED:
        for change in CHANGES:
            yield f"{case} {change}", partial(verdict, case, change)


# --- many motions, dynamics, proofs

CHAOTIC, REGULAR, TOP_CASE = (
    "general/asymmetric-chaotic",
    "general/asymmetric-regular",
    "lagrange/nutation",
)
GRID = {"start.omega[3]": "2:4:5", "body.weight": [1, "3/2", 0.1]}
LISTED = [{"start.omega[1]": "0.3"}, {"start.omega[1]": 1}, {"start.omega[1]": 0.7}]


def sweeps() -> Entries:
    def of(case: str, varied: Any, **options: Any) -> Any:
        many = polhode.integrate_many(case, varied, workers=1, **options)
        return {"bits": many.number.bits, **attributes(many, "times states outcomes reached")}

    def kept(names: list[str], at: Sequence[Any]) -> Any:
        numbers = polhode.reduce_many(TOP_CASE, GRID, names, at=at, workers=1)
        return {name: numbers[name] for name in numbers.names}

    yield "a grid", partial(of, TOP_CASE, GRID, at=[0, 1, 40])
    yield "backward, listed", partial(of, "kovalevskaya/generic", LISTED, at=[-1, "-31/3"])
    yield "a tolerance", partial(of, "euler/largest-axis", LISTED, at=[10], tol="1e-9")
    yield "extended", partial(of, REGULAR, LISTED, at=[1, 50], number="extended")
    yield "quad", partial(of, REGULAR, LISTED, at=[1, 20], number="quad")
    yield "no such key", partial(of, TOP_CASE, {"start.omga[3]": "2:4:3"})
    yield "kept numbers", partial(kept, ["largest theta", "smallest gamma3"], range(1, 60))
    yield "kept events", partial(kept, ["first nutation", "first equator"], [30])
    yield "kept exponents", partial(kept, ["lyapunov"], [100, 200])


def dynamics() -> Entries:
    def cut(**options: Any) -> Any:
        section = polhode.section(CHAOTIC, crossings=20, workers=1, **options)
        told = attributes(section, "starts states times l L_over_G counts outcomes")
        return {"ratio" if name == "L_over_G" else name: value for name, value in told.items()}

    yield "section momentum", partial(cut, grid=(3, 3), h=3, f="1/2")
    yield "section q", partial(cut, by="q", grid=(2, 2), h=2, f="0.3")
    yield "section of a start", partial(cut, starts="scene")
    yield "section of no level", partial(cut, grid=(2, 2), h=-100)
    yield (
        "map",
        lambda: attributes(
            polhode.chaos_map(CHAOTIC, (5, 4), h=3, f="1/2", workers=1),
            "shape at cell verdict fli megno",
        ),
    )
    yield (
        "orbit",
        lambda: attributes(
            polhode.orbit("grioli/precession", 25), "h f digits period residue kind multipliers"
        ),
    )
    for case in (*CASES[::20], REGULAR):
        yield (
            f"levels {case}",
            lambda case=case: attributes(polhode.levels(case), "curves marks here"),
        )
        yield (
            f"frequencies {case}",
            lambda case=case: attributes(polhode.frequencies(case, lines=3), "lines known"),
        )
        yield (
            f"conditioning {case}",
            lambda case=case: attributes(
                polhode.conditioning(case, [1, 10]), "log10_kappa log10_amplification lost_after"
            ),
        )


def proofs() -> Entries:
    def enclosure(case: str, at: list[Any], digits: int) -> Any:
        scene = replace(polhode.load(case), outputs=("attitude", "angles"))
        ball = polhode.certify(scene, at=at, digits=digits)
        return attributes(ball, "times centres digits outcome") | {"bits": 53}

    def events(case: str) -> Any:
        scene = replace(polhode.load(case), events=EVENTS[0])
        return [attributes(one, "name times") for one in polhode.certify_events(scene, end=9)]

    def certificate(case: str, mode: str) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            file = str(Path(folder) / "certificate.json")
            code = _quiet("prove", mode, case, "-o", file)[0]
            verified = _quiet("verify", file)[0] if Path(file).exists() else None
        return {"prove": code, "verify": verified}

    yield "asymmetric", partial(enclosure, REGULAR, [1, 10], 30)
    yield "chaotic", partial(enclosure, CHAOTIC, [5, "-7/3"], 15)
    yield "euler", partial(enclosure, "euler/largest-axis", [100], 20)
    yield "brick", partial(enclosure, "published/nasa-brick", [30], 15)
    yield "events", partial(events, REGULAR)
    for case in ("grioli/precession", "bobylev-steklov/cn", REGULAR):
        yield f"orbit {case}", partial(certificate, case, "orbit")
    yield "chaos", partial(certificate, CHAOTIC, "chaos")


# --- the keys of JSON

COMMANDS = """
list
about
show lagrange/nutation
run euler/attitude --at 0,1 --outputs angles,attitude
reference lagrange/nutation --at 1
certify general/section --at 1 --digits 9
check euler/attitude
sweep lagrange/nutation --vary start.omega[3]=2:4:2 --at 1
levels lagrange/nutation
section general/asymmetric-chaotic --grid 2x2 --crossings 3
map general/asymmetric-chaotic --grid 2x2
orbit grioli/precession --digits 12
frequencies euler/attitude
prove orbit grioli/precession
""".strip().splitlines()


def _quiet(*words: str) -> tuple[int, str]:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        code = command_line([*words])
    return code, out.getvalue()


def _json(*words: str) -> Any:
    code, text = _quiet(*words, "--json")
    if not text:
        raise ValueError(f"exit code {code}, no JSON")
    return json.loads(text)


def keys(value: Any) -> Any:
    """The keys of a JSON document, of lists those of the first element."""
    if isinstance(value, dict):
        return {key: keys(one) for key, one in sorted(value.items())}
    if isinstance(value, list):
        return [keys(value[0])] if value else []
    return type(value).__name__


def documents() -> Entries:
    for command in COMMANDS:
        yield command, lambda command=command: keys(_json(*command.split()))


#: What takes longest first, so that the last processes end together.
PARTS: dict[str, Callable[[], Entries]] = {
    "closed forms": closed_forms,
    "runs": runs,
    "verdicts": verdicts,
    "dynamics": dynamics,
    "proofs": proofs,
    "sweeps": sweeps,
    "documents": documents,
}


# --- records: made, read, compared


def make(target: Path, parts: Sequence[str], workers: int) -> None:
    """Write the record of some parts."""
    begin = time.monotonic()
    record = {**record_of(parts, workers), "made by": maker()}
    beside = target.with_name(target.name + ".new")
    text = json.dumps(record, indent=0, sort_keys=True)
    beside.write_bytes(gzip.compress(text.encode(), mtime=0))
    beside.replace(target)
    count = sum(len(record[part]) for part in parts)
    print(f"{target}: {count} entries, {time.monotonic() - begin:.0f} s", file=sys.stderr)


def maker() -> dict[str, str]:
    return {"polhode": polhode.__version__, "processor": processor()}


def processor() -> str:
    """Its name, where Linux tells it."""
    with contextlib.suppress(OSError):
        if match := re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()):
            return match[1]
    return platform.machine()


def record_of(parts: Sequence[str], workers: int) -> dict[str, Any]:
    """The record of some parts, a process each."""

    def one(part: str) -> Any:
        words = [sys.executable, __file__, "part", part]
        one_thread = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        done = subprocess.run(words, env={**os.environ, **one_thread}, stdout=subprocess.PIPE)
        if done.returncode:
            sys.exit(f"{part}: exit code {done.returncode}")
        return json.loads(done.stdout)

    with ThreadPoolExecutor(workers) as pool:
        return dict(zip(parts, pool.map(one, parts), strict=True))


def part(name: str) -> dict[str, Any]:
    """One part, in this process; a line on stderr now and then."""
    record, entries = {}, [*PARTS[name]()]
    last = time.monotonic()
    for k, (key, entry) in enumerate(entries, 1):
        record[key] = answer(entry)
        if time.monotonic() - last > 10:
            last = time.monotonic()
            print(f"{name}: {k} of {len(entries)}", file=sys.stderr, flush=True)
    return record


def read(file: Path) -> dict[str, Any]:
    return json.loads(gzip.decompress(file.read_bytes()))


class Difference(NamedTuple):
    """An entry that is not the same: how many leaves differ, the worst, or one that is no number.

    ``ulps``: of the numbers among them, the largest; None where none can be measured so.
    """

    part: str
    entry: str
    what: str
    count: int
    ulps: float | None

    def __str__(self) -> str:
        ulps = "" if self.ulps is None else f", up to {self.ulps:.3g} ulp"
        many = "1 difference" if self.count == 1 else f"{self.count} differences"
        return f"{self.part}: {self.entry}: {many}{ulps}: {self.what}"


def differences(one: Mapping[str, Any], two: Mapping[str, Any]) -> Iterator[Difference]:
    """Every entry of either record that is not the same in the other."""
    for name in sorted({*one, *two} - {"made by"}):
        first, second = one.get(name, {}), two.get(name, {})
        for entry in sorted({*first, *second}):
            if entry not in first or entry not in second:
                which = "first" if entry not in first else "second"
                yield Difference(name, entry, f"missing in the {which}", 1, None)
            elif first[entry] != second[entry]:
                yield _difference(name, entry, first[entry], second[entry])


def _difference(name: str, entry: str, one: Any, two: Any) -> Difference:
    leaves = [(path, a, b, ulps(a, b, bits)) for path, a, b, bits in _leaves(one, two)]
    numbers = [far for *_, far in leaves if far is not None]
    words = [leaf for leaf in leaves if leaf[3] is None]
    path, a, b, _ = words[0] if words else max(leaves, key=lambda leaf: leaf[3])
    what = f"{path or 'value'}: {str(a)[:100]} and {str(b)[:100]}"
    return Difference(name, entry, what, len(leaves), max(numbers, default=None))


def ulps(one: object, two: object, bits: int) -> float | None:
    """How far apart two texts of numbers are, in units of the last place of the larger one."""
    first, second = number_of(one), number_of(two)
    if first is None or second is None:
        return None
    size = max(abs(first), abs(second))
    if size == 0:
        return 0.0  # 0 and -0
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    if size < Fraction(2) ** exponent:
        exponent -= 1
    return float(min(abs(first - second) / Fraction(2) ** (exponent + 1 - bits), 10**300))


MISSING = "nothing"


def _leaves(
    one: Any, two: Any, path: str = "", bits: int = 53
) -> Iterator[tuple[str, Any, Any, int]]:
    """The leaves in which two values differ, with the bits of the nearest "bits" above them."""
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        width = str(one.get("bits"))
        bits = int(width) if width.isdigit() else bits  # the keys of a JSON say "int" there
        for key in sorted({*one, *two}):
            below = f"{path}.{key}" if path else key
            yield from _leaves(one.get(key, MISSING), two.get(key, MISSING), below, bits)
    elif isinstance(one, list) and isinstance(two, list):
        for k in range(max(len(one), len(two))):
            pair = (x[k] if k < len(x) else MISSING for x in (one, two))
            yield from _leaves(*pair, f"{path}[{k}]", bits)
    elif one != two or type(one) is not type(two):
        yield path, one, two, bits


def compare(one: Mapping[str, Any], two: Mapping[str, Any]) -> int:
    """Print what differs; 1 if anything does."""
    count = 0
    for difference in differences(one, two):
        print(difference)
        count += 1
    entries = sum(len(record) for name, record in one.items() if name != "made by")
    print(f"not equal: {count} of {entries} entries" if count else f"equal: {entries} entries")
    return 1 if count else 0


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="what", required=True)
    making, checking = commands.add_parser("make"), commands.add_parser("check")
    making.add_argument("target", type=Path)
    for command in (making, checking):
        command.add_argument("--part", nargs="+", default=[*PARTS], choices=[*PARTS])
        command.add_argument("--workers", type=int, default=2)
    within = commands.add_parser("part")  # what make calls
    within.add_argument("part", choices=[*PARTS])
    comparing = commands.add_parser("diff")
    comparing.add_argument("files", nargs=2, type=Path)
    options = parser.parse_args(words)
    match options.what:
        case "make":
            make(options.target, options.part, options.workers)
        case "part":
            print(json.dumps(part(options.part)))
        case "check":
            before = read(ROWS)
            return compare(
                {name: before[name] for name in options.part},
                record_of(options.part, options.workers),
            )
        case "diff":
            return compare(*map(read, options.files))
    return 0


if __name__ == "__main__":
    sys.exit(main())
