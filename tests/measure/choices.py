"""What is chosen for the user, measured.

    PYTHONPATH=reports python tests/measure/choices.py [PART...] > reports/choices.md

Processor time of one thread, least of several; builds without the disk cache.  Nothing here passes
or fails.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import heyoka as hy
import numpy as np

import long_run
import polhode
from polhode.common.provenance import cpu, versions
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.runs.options import Options
from polhode.runs.taylor_motion import TaylorMotion, system_of
from polhode.scenes import library, scene_file
from polhode.taylor import batches, defaults, heyoka
from polhode.taylor.system import system

SCENE = (
    "schema = 1\n[body]\nmoments = [2, 3, 4]\ncentre = [0.3, 0.2, 0.5]\nweight = 1\n[start]\n"
    'omega = [0.3, 0.4, {spin}]\ngamma = ["2/7", "3/7", "6/7"]\n[run]\nend = {end}\n'
)
TYPES = {
    "double": number_types.DOUBLE,
    "extended": number_types.EXTENDED,
    "quad": number_types.QUAD,
    "mp": number_types.mp(),
}


def heavy(end: Any, spin: str = "3") -> polhode.Scene:
    return scene_file.parse(SCENE.format(end=end, spin=spin), "heavy")


def least(job: Callable[[], Any], rounds: int, clock: Callable[[], float] = time.thread_time):
    """The least seconds of a job, and what it gave."""
    best = float("inf")
    for _ in range(rounds):
        began = clock()
        found = job()
        best = min(best, clock() - began)
    return best, found


def table(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    header = list(header)
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(str(x) for x in row) + " |")
    print()


@contextmanager
def no_disk_cache():
    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    yield
    hy.llvm_state.set_diskcache_enabled(True)


def built(scene: polhode.Scene, number: Any, **options: Any) -> Any:
    """heyoka's integrator of a scene with options of its own, and the seconds of its build."""
    what = system(scene, ())
    variables = hy.make_vars(*what.names)
    k = {name: hy.expression(heyoka.scalar(x, number)) for name, x in what.coefficients.items()}
    rates = what.field(variables, k, heyoka.EXPRESSIONS)
    start = heyoka.array([heyoka.scalar(x, number) for x in what.start], number)
    chosen = heyoka.type_options(number) | options
    equations = list(zip(variables, rates, strict=True))
    with no_disk_cache():
        return least(lambda: hy.taylor_adaptive(equations, start, **chosen), 1)


def tolerances() -> None:
    print("## Tolerance of a step: the type's eps (2⁻⁵² in double)\n")
    print(
        "`--tol` loosens it. Heavy top, double, t = 1000; the error of the state against a "
        "quad run of the same rounded inputs, median of seven starts. Below eps more work "
        "buys no digit, so that is refused. Between 1e-14 and eps it buys next to none: a fifth "
        "of the time, so that what is left is the rounding of the steps and no tolerance.\n"
    )
    scenes = [heavy(1000, f"1.{k}1") for k in range(7)]
    true = []
    for scene in scenes:
        made = system_of(scene, number_types.QUAD, inputs=number_types.DOUBLE)
        true.append(
            TaylorMotion(made, scene, options=Options(project=False)).advance(made.times(scene))[0][
                -1
            ]
        )
    rows = []
    for name, tol in [
        ("eps/1000", number_types.DOUBLE.eps / 1000),
        ("eps/10", number_types.DOUBLE.eps / 10),
        ("**eps**", number_types.DOUBLE.eps),
        ("10 eps", number_types.DOUBLE.eps * 10),
        ("1e-14", Fraction(1, 10**14)),
        ("1e-12", Fraction(1, 10**12)),
        ("1e-10", Fraction(1, 10**10)),
        ("1e-8", Fraction(1, 10**8)),
    ]:
        best, errors = float("inf"), []
        for scene, exact in [*zip(scenes, true, strict=True), *[(scenes[0], true[0])] * 14]:
            made = system_of(scene, number_types.DOUBLE, tol)
            motion, began = (
                TaylorMotion(made, scene, options=Options(project=False)),
                time.perf_counter(),
            )
            row = motion.advance(made.times(scene))[0][-1]
            taken = time.perf_counter() - began
            pairs = zip(row, exact, strict=True)
            errors.append(max(abs(float(exactly(a) - exactly(b))) for a, b in pairs))
            if scene is scenes[0]:
                steps, seconds = motion.steps, taken - motion.build_seconds
                best = min(best, seconds)
        rows.append([name, steps, f"{best * 1e3:.2f}", f"{np.median(errors[:7]):.1e}"])
    table(["tolerance", "steps", "ms", "error"], rows)


def compact() -> None:
    print("## Compact mode: for quad and mp\n")
    print("Code unrolled (default) against loops over functions (compact).\n")
    rows = []
    steps = {"double": 20_000, "extended": 2_000, "quad": 60, "mp": 12}
    for name, number in TYPES.items():
        for mode in (False, True):
            if name == "mp" and not mode:
                rows.append([name, "unrolled", "does not end", "", ""])
                continue
            build, ta = built(heavy(1), number, compact_mode=mode)
            far = heyoka.scalar(10**6, number)
            n = steps[name]
            seconds, _ = least(lambda ta=ta, n=n, far=far: ta.propagate_until(far, max_steps=n), 7)
            default = {"quad": True, "mp": True}.get(name, False)
            mark = "**chosen**" if mode == default else ""
            cells = ["compact" if mode else "unrolled", f"{build * 1e3:.0f}"]
            rows.append([name, *cells, f"{seconds / n * 1e6:.3g}", mark])
    table(["type", "mode", "build, ms", "µs a step", ""], rows)


def digits() -> None:
    print("## Number type and guard from `--digits`\n")
    print(
        "The cheapest type that holds the digits wanted, ceil(log10(|w|·|end|)) guard digits, and "
        "what the motion is expected to lose; the run is checked, and made again in a wider type "
        "where digits are missing. Digits that are correct, by the closed form, at the end of "
        "regular motions of 100 radians and of 1000, and the type (bits) that was taken.\n"
    )
    cases = ["lagrange/nutation", "euler/largest-axis", "kovalevskaya/generic"]
    rows = []
    for wanted in (8, 12, 15, 18, 25, 33, 50):
        for angle in (100, 1000):
            if wanted == 50 and angle == 1000:
                continue
            cells = []
            for case in cases:
                scene = library.load(case)
                end = Fraction(round(angle * 10**-scene.log10_rate * 2**20), 2**20)
                scene = scene.at((end,))
                run = polhode.integrate(scene, digits=wanted)
                judged = polhode.compare(run, polhode.reference(scene))
                right = min(judged.digits)
                short = " (short)" if right < wanted else ""
                cells.append(f"{right:.1f}{short}, {run.number.name} ({run.number.bits})")
            rows.append([wanted, angle, *cells])
    table(["wanted", "radians", *cases], rows)


def chunks() -> None:
    print("## Chunk length: a fifth of a second of steps, by type\n")
    print(
        "Between chunks a run checks for Ctrl-C, reports progress and resets its clock to 0. "
        "Double, t = 100 000, against chunks of 200 000 steps.\n"
    )
    scene = heavy(100_000)
    rows, base = [], 0.0
    before = dict(defaults.TABLE)
    for steps in (200_000, 20_000, 2_000, 200, 20):
        defaults.TABLE["double"] = before["double"]._replace(chunk=steps)

        def job() -> float:
            run = polhode.integrate(scene)
            return run.provenance["seconds"]["run"]

        best = min(job() for _ in range(5))
        base = base or best
        wait = steps * 0.6e-3
        rows.append([f"{steps}", f"{best / base:.2f}", f"{wait:.3g}"])
    defaults.TABLE.update(before)
    rows[0][0] = f"**{rows[0][0]}**"
    table(["steps a chunk", "time", "wait for Ctrl-C, ms"], rows)
    print(", ".join(f"{n}: {defaults.of(t).chunk} steps" for n, t in TYPES.items()) + ".\n")


def cadences() -> None:
    print("## Steps between two projections onto the first integrals, by type\n")
    print(
        "`--project N` sets them, `--no-project` turns projection off; quad and mp are not "
        "projected unless asked. Median error over eight starts a top, and time, against runs that "
        "are not projected: double to t = 10 000, extended to t = 1000.\n"
    )
    for name, end, chosen in (("double", 10_000, 320), ("extended", 1000, 32)):
        rows: dict[str, list[str]] = {}
        for top in long_run.TOPS:
            scenes = [long_run.RunStart(top, k, (Fraction(end),), ()).scene for k in range(8)]
            truths = [polhode.reference(scene).at(scene.times, 30) for scene in scenes]
            plain, slow = projected(scenes, truths, name, False)
            for every in (8, 32, 80, 160, 320, 640):
                error, seconds = projected(scenes, truths, name, every)
                label = f"**{every}**" if every == chosen else str(every)
                cells = [f"1/{plain / error:.0f}", f"{seconds / slow:.2f}"]
                rows.setdefault(label, []).extend(cells)
        print(f"{name}:\n")
        tops = [f"{top}, {what}" for top in long_run.TOPS for what in ("error", "time")]
        table(["steps", *tops], [[label, *cells] for label, cells in rows.items()])


def projected(scenes: Any, truths: Any, name: str, project: Any) -> tuple[float, float]:
    """The median error at the end, and the least seconds of the first run."""
    errors = []
    for scene, truth in zip(scenes, truths, strict=True):
        run = polhode.integrate(scene, name, project=project)
        rate = log10_rate(truth, scene)
        errors.append(float(10 ** log10_errors(run.states, truth, rate)[-1]))
    seconds, _ = least(lambda: polhode.integrate(scenes[0], name, project=project), 7)
    return float(np.median(errors)), seconds


def lanes() -> None:
    print(f"## Batch width of a sweep: {batches.LANES}\n")
    print(
        "The same top in every lane, 20 000 steps each; scalar code with constants and with "
        "parameters for comparison.\n"
    )
    scene, n = heavy(1), 20_000
    what = system(scene, ())
    names = sorted(what.coefficients)
    values = [float(what.coefficients[name]) for name in names]
    variables = hy.make_vars(*what.names)
    k = {name: hy.par[i] for i, name in enumerate(names)}
    equations = list(zip(variables, what.field(variables, k, heyoka.EXPRESSIONS), strict=True))
    start = np.array([float(x) for x in what.start])
    rows = []
    build, ta = built(scene, number_types.DOUBLE)
    seconds, _ = least(lambda: ta.propagate_until(1e9, max_steps=n), 9)
    rows.append(["scalar, constants", f"{build * 1e3:.0f}", f"{seconds / n * 1e6:.3f}", ""])
    with no_disk_cache():
        build, ta = least(lambda: hy.taylor_adaptive(equations, start, pars=values), 1)
    scalar, _ = least(lambda: ta.propagate_until(1e9, max_steps=n), 9)
    rows.append(["scalar, parameters", f"{build * 1e3:.0f}", f"{scalar / n * 1e6:.3f}", "1"])
    for width in (2, 4, 8, 16):
        states, pars = (np.tile(np.array(x)[:, None], width) for x in (start, values))
        with no_disk_cache():
            build, many = least(
                lambda s=states, p=pars: hy.taylor_adaptive_batch(equations, s, pars=p), 1
            )
        seconds, _ = least(
            lambda m=many, w=width: m.propagate_until(np.full(w, 1e9), max_steps=n), 9
        )
        each = seconds / n / width
        name = f"**{width}**" if width == batches.LANES else str(width)
        cells = [f"{build * 1e3:.0f}", f"{each * 1e6:.3f}", f"{scalar / n / each:.2f}"]
        rows.append([name, *cells])
    table(["lanes", "build, ms", "µs a step and lane", "times scalar"], rows)


def arrays() -> None:
    row, usual = defaults.ARRAYS, polhode.propagator(heavy(1))
    print("## Arrays of starts: one compiled step, or batches\n")
    print(
        "Starts of a heavy top with |w| to about 3 by a propagator whose tolerance is above eps: "
        "processor time of batches of heyoka's own order over that of batches of a higher one, and "
        "of one compiled step for all starts; median and largest error of each. From "
        f"{row.starts} starts on, for motions that turn by at most {row.radians:.0f} radians by "
        f"their bound, and with a tolerance of at least {row.finest:.0e}, the step is taken: "
        "compiling it takes some tenths of a second or more, once, and heyoka's cache keeps it.\n"
    )
    rows, rng = [], np.random.default_rng(1)
    for count in (128, row.starts, 8 * row.starts):
        gamma = rng.normal(size=(count, 3))
        gamma /= np.sqrt((gamma * gamma).sum(axis=1))[:, None]
        starts = np.hstack([rng.normal(size=(count, 3)), gamma])
        for t in (1.0, 10.0):
            exact = usual(starts, t=t, workers=1)
            for tol in (1e-5, 1e-8, 1e-11):
                own, go = (polhode.propagator(heavy(1), tol=tol) for _ in range(2))
                vars(own)["_job"] = own._job._replace(order=0)
                times, errors = [], []
                for ready, least_starts in ((own, count + 1), (go, count + 1), (go, 1)):
                    defaults.ARRAYS = row._replace(starts=least_starts)
                    seconds, states = least(lambda g=ready, x=starts, t=t: g(x, t=t, workers=1), 7)
                    off = np.abs(states - exact).max(axis=1)
                    times.append(seconds)
                    errors.append(f"{np.median(off):.0e}, {off.max():.0e}")
                defaults.ARRAYS = row
                name = f"**{count}**" if (count, t, tol) == (row.starts, 1.0, 1e-5) else str(count)
                ratios = [f"{times[0] / x:.2f}" for x in times[1:]]
                rows.append([name, f"{t:.0f}", f"{tol:.0e}", *ratios, *errors])
    ways = "batches", "higher order", "one step"
    header = [
        "starts",
        "t",
        "tolerance",
        "higher order",
        "one step",
        *(f"{w}: error" for w in ways),
    ]
    table(header, rows)


def main() -> None:
    print("# What is chosen for the user\n")
    own, *others = (f"{name} {version}" for name, version in versions().items())
    print(
        f"Measured by `tests/measure/choices.py`, with {own} "
        f"({', '.join(others)}; {cpu()}). "
        "The choice is in **bold** type.\n"
    )
    parts = (tolerances, compact, digits, chunks, cadences, lanes, arrays)
    for part in (p for p in parts if p.__name__ in sys.argv[1:] or len(sys.argv) == 1):
        began = time.perf_counter()
        part()
        print(f"{part.__name__}: {time.perf_counter() - began:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
