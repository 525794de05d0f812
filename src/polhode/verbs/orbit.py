"""``polhode orbit``: periodic orbits, one to many digits, a family, or all that a level shows."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.text_tables import counted
from polhode.numbers import expression
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.scenes import library
from polhode.verbs.section import level_options, read_grid
from polhode.verbs.terminal import (
    DONE,
    INTERRUPTED,
    NOT_REACHED,
    ProgressLine,
    note,
    positive,
    print_json,
    print_table,
    refuse_two_on_stdout,
    say,
    word,
)

if TYPE_CHECKING:
    from polhode.dynamics.periodic_orbits.families import FamilyPoint, OrbitFamily
    from polhode.dynamics.periodic_orbits.orbit import Orbit
    from polhode.proofs.proved_orbit import ProvedOrbit

HELP = "periodic orbits to any number of digits, their stability, their families"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument(
        "--digits", type=positive, metavar="D", help="digits of start and period (15)"
    )
    parser.add_argument("--period", metavar="T", help="a guess of the period")
    returns = "number of near returns of the motion to try (10); in a search, of crossings (3)"
    parser.add_argument("--returns", type=positive, metavar="N", help=returns)
    search = "search the level from N x M cells of its section (20x20)"
    parser.add_argument("--search", metavar="NxM", nargs="?", const="20x20", help=search)
    parser.add_argument("--pick", type=positive, metavar="K", help="the K-th orbit of the search")
    along = "the family along h (or f), at most N orbits (200), through folds"
    parser.add_argument("--continue", dest="along", metavar="h=[FROM:]TO[:N]", help=along)
    output = "the start as a scene, .toml; a family or a search as .npz; a family as .svg .png .pdf"
    proof = "prove that the orbit exists, or each one of a search: see polhode prove"
    parser.add_argument("--prove", action="store_true", help=proof)
    level_options(parser, output)


def main(options: Namespace) -> int:
    """Find one orbit, a family, or the orbits of a level."""
    scene = library.load(options.scene)
    if options.pick is not None and options.search is None:
        raise BadInput(scene.name, "--pick", options.pick, "--search, whose orbits it counts")
    if options.search is not None and (options.along or options.period):
        raise BadInput(scene.name, "--search", options.search, "neither --continue nor --period")
    if options.prove and options.along:
        raise BadInput(scene.name, "--prove", None, "no --continue: a family is not proved")
    if options.along is not None:
        return _family(options, scene)
    if options.search is not None:
        return _search(options, scene)
    return _orbit(options, scene)


def _orbit(options: Namespace, scene: Any) -> int:
    from polhode.dynamics.periodic_orbits.orbit import DIGITS, orbit

    path = _scene_file(options)
    with ProgressLine("orbit") as progress:
        found = orbit(
            scene,
            options.digits or DIGITS,
            options.h,
            options.f,
            options.period,
            options.returns,
            progress.say,
        )
    return _one(options, path, found)


def _scene_file(options: Namespace) -> Path | None:
    """The path of -o, if a scene can be written there."""
    from polhode.common.files import check_writable

    if options.file is None:
        return None
    path = Path(options.file)
    check_writable(path, [".toml"], [library.path_of(options.scene)])
    refuse_two_on_stdout(path, options.json)
    return path


def _one(options: Namespace, path: Path | None, found: Orbit) -> int:
    from polhode.common.files import is_stdout, write_whole
    from polhode.output import orbits as output
    from polhode.output import proofs
    from polhode.scenes.scene_text import as_toml

    proof: ProvedOrbit | None = None
    if options.prove:
        from polhode.proofs.prove_orbit import DIGITS, MOST_DIGITS, prove_orbit
        from polhode.proofs.refusals import NotProved

        surface, digits = found.surface, min(max(DIGITS, found.digits), MOST_DIGITS)
        try:
            proof = prove_orbit(surface.scene, found, digits, surface.h, surface.f)
        except NotProved as why:
            note(f"polhode: not proved: {why}")
            return NOT_REACHED
    if path is not None:
        write_whole({path: as_toml(found.scene)})
    if options.json:
        answer = output.of_orbit(found)
        if proof is not None:
            answer["proof"] = proofs.of_proof(proof)
        print_json(answer)
    elif path is None or not is_stdout(path):
        _say(found)
        if proof is not None:
            say(f"proof       {proof}")
    return DONE


def _say(found: Orbit) -> None:
    from polhode.output import orbits as output

    told = output.of_orbit(found)
    say(f"period      {told['period']}")
    say(f"omega       {', '.join(told['omega'])}")
    say(f"gamma       {', '.join(told['gamma'])}")
    say(f"level       h = {told['h']}, f = {told['f']}")
    say(f"residue     {told['residue']}, {told['kind']}")
    for real, imaginary in told["multipliers"]:
        sign = "-" if imaginary.startswith("-") else "+"
        say(
            f"multiplier  {real}"
            + (f" {sign} {imaginary.lstrip('-')} i" if imaginary != "0" else "")
        )
    if told["psi"] is None:
        say("psi         not known")
    else:
        closes = "the motion in space does not close in few periods"
        if found.turns is not None:
            n = found.turns.denominator
            closes = f"the motion in space closes after {counted(n, 'period')}"
        say(f"psi         {told['psi']} per period; {closes}")
    note(
        f"{found.name}: start and period right to {found.error:.1e}, residue to "
        f"{found.residue_error:.1e}, |det M - 1| = {found.determinant:.1e}; "
        f"{found.moved:.2g} from the guess"
    )


def _search(options: Namespace, scene: Any) -> int:
    from polhode.dynamics.periodic_orbits.orbit import DIGITS
    from polhode.dynamics.periodic_orbits.search import orbit_search
    from polhode.output import orbits as output
    from polhode.output import proofs
    from polhode.verbs.answer_file import ARRAYS, answer_file

    path, file = None, None
    if options.pick is None:
        inputs = [library.path_of(options.scene)]
        file = answer_file(options.file, [ARRAYS], inputs, options.json)
    else:
        path = _scene_file(options)
    grid = read_grid(scene.name, options.search)
    with ProgressLine("orbit") as progress:
        found = orbit_search(scene, grid, options.returns, options.h, options.f, progress.say)
        if options.pick is not None:
            if options.pick > len(found.orbits):
                expected = f"a number to {len(found.orbits)}: so many orbits were found"
                raise BadInput(scene.name, "--pick", options.pick, expected)
            one = found.orbit(options.pick - 1, options.digits or DIGITS)
    if options.pick is not None:
        return _one(options, path, one)
    if file is not None:
        file.save(output.arrays(found))
    proved = None
    if options.prove:
        from polhode.proofs.prove_orbit import prove_all

        proved = prove_all(found)
    if options.json:
        answer = output.of_search(found)
        if proved is not None:
            answer["proofs"] = [proofs.of_result(one) for one in proved]
        print_json(answer)
    elif file is None or not file.on_stdout:
        columns = ["orbit", "period", "residue", "kind", "p", "q", "r"]
        rows = [
            [
                str(k),
                f"{point.period:.12g}",
                f"{point.residue:.6g}",
                point.kind,
                *(f"{x:.6g}" for x in point.state[:3]),
            ]
            for k, point in enumerate(found.orbits, 1)
        ]
        if proved is not None:
            columns.append("proof")
            rows = [[*row, proofs.line_of(one)] for row, one in zip(rows, proved, strict=True)]
        print_table(columns, rows)
    counted = "" if proved is None else f", {proofs.count(proved)}"
    note(f"{scene.name}: {found!r}{counted}; no list is complete")
    if found.interrupted:
        return INTERRUPTED
    return DONE if proved is None or proofs.all_proved(proved) else NOT_REACHED


class Range(NamedTuple):
    """What ``--continue`` asks for."""

    by: str
    first: Exact | None
    last: Exact
    points: int


def read_range(name: str, text: str) -> Range:
    """``h=TO``, ``h=FROM:TO`` or ``h=FROM:TO:N``, likewise of f."""
    from polhode.dynamics.periodic_orbits.families import MOST_POINTS, POINTS

    by, equals, rest = text.partition("=")
    parts = rest.split(":")
    try:
        if by not in ("h", "f") or not equals or len(parts) > 3:
            raise ValueError
        points = int(parts[2]) if len(parts) == 3 else POINTS
        if not 2 <= points <= MOST_POINTS:
            raise ValueError
        ends = [expression.number(part) for part in parts[:2]]
    except (ExpressionError, ValueError):
        expected = "h=TO, h=FROM:TO or h=FROM:TO:N with N from 2, or the same of f"
        raise BadInput(name, "--continue", text, expected) from None
    return Range(by, ends[0] if len(ends) == 2 else None, ends[-1], points)


def _family(options: Namespace, scene: Any) -> int:
    from polhode.dynamics.periodic_orbits.families import orbit_family
    from polhode.dynamics.periodic_orbits.orbit import orbit
    from polhode.figures.canvas import canvas
    from polhode.output import orbits as output
    from polhode.verbs.answer_file import ARRAYS, answer_file

    asked = read_range(scene.name, options.along)
    if options.digits is not None:
        raise BadInput(scene.name, "--digits", options.digits, "none: a family is one of doubles")
    inputs = [library.path_of(options.scene)]
    file = answer_file(options.file, (ARRAYS, *canvas.SUFFIXES), inputs, options.json)
    level = {"h": options.h, "f": options.f}
    if asked.first is not None:
        if level[asked.by] is not None:
            raise BadInput(scene.name, f"--{asked.by}", level[asked.by], "it in --continue alone")
        level[asked.by] = asked.first
    with ProgressLine("orbit") as progress:
        first = orbit(
            scene,
            h=level["h"],
            f=level["f"],
            period=options.period,
            returns=options.returns,
            progress=progress.say,
        )
        found = orbit_family(
            first, asked.by, asked.last, points=asked.points, progress=progress.say
        )
    if file is not None:
        if file.holds_arrays:
            file.save(output.arrays(found))
        else:
            file.draw(found, scene.name)
    if options.json:
        print_json(output.of_family(found))
    elif file is None or not file.on_stdout:
        print_table(*table(found))
    note(f"{scene.name}: {found!r}")
    if found.interrupted:
        return INTERRUPTED
    return DONE if found.complete else NOT_REACHED


def table(found: OrbitFamily) -> tuple[list[str], list[list[str]]]:
    """Header and a line for each orbit, bifurcations between them."""
    rows: list[list[str]] = []
    for k, point in enumerate(found.points):
        rows += [_row(one.what, one.point) for one in found.bifurcations if one.after == k]
        rows.append(_row(str(k + 1), point))
    last = len(found.points)
    rows += [_row(one.what, one.point) for one in found.bifurcations if one.after >= last]
    return ["orbit", "h", "f", "period", "residue", "kind"], rows


def _row(first: str, point: FamilyPoint) -> list[str]:
    numbers: Sequence[float] = (point.h, point.f, point.period)
    kind = "" if not first.isdigit() else point.kind
    return [first, *(f"{x:.12g}" for x in numbers), f"{point.residue:.6g}", kind]
