"""``polhode prove``: computer-assisted proofs."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.common.files import check_writable, is_stdout
from polhode.common.text_tables import counted
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.verbs.section import read_grid
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
    tell_certificate,
    word,
)

if TYPE_CHECKING:
    from polhode.proofs.chaos.proved_chaos import ProvedChaos
    from polhode.proofs.proved_orbit import ProvedOrbit
    from polhode.proofs.refusals import NotProved

HELP = "proofs: that a periodic orbit exists, where, how stable it is; that a level is chaotic"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("what", choices=["orbit", "chaos"], help="what is to be proved")
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument(
        "--digits", type=positive, metavar="D", help="digits of start and period (30)"
    )
    parser.add_argument("--orbit", type=word, metavar="FILE", help="a guess: a scene of one period")
    parser.add_argument("--period", metavar="T", help="a guess of the period")
    returns = "number of near returns of the motion to try (10); in a search, of crossings (3)"
    parser.add_argument("--returns", type=positive, metavar="N", help=returns)
    search = "all orbits of a search from N x M cells of the level's section (20x20)"
    parser.add_argument("--search", metavar="NxM", nargs="?", const="20x20", help=search)
    parser.add_argument("--pick", type=positive, metavar="K", help="the K-th orbit of the search")
    out = "the proof's certificate, for polhode verify; in a search with --pick only"
    parser.add_argument("-o", type=word, dest="file", metavar="CERT.json", help=out)
    tries = "with chaos: number of homoclinic orbits and sizes of sets to try (12)"
    parser.add_argument("--tries", type=positive, metavar="N", help=tries)
    bodies = "with orbit: for every body whose moments and Mg r0 are within X (relative)"
    parser.add_argument("--tolerance", metavar="X", help=bodies)
    for key in ("h", "f"):
        parser.add_argument(f"--{key}", metavar="X", help=f"{key} of the level, if not the scene's")


def main(options: Namespace) -> int:
    """Prove one orbit, or those of a search; or chaos."""
    scene = library.load(options.scene)
    if options.what == "chaos":
        return _chaos(options, scene)
    if options.tries is not None:
        raise BadInput(scene.name, "--tries", options.tries, "with chaos only")
    guesses = [
        f"--{key}" for key in ("orbit", "period", "search") if getattr(options, key) is not None
    ]
    if len(guesses) > 1:
        raise BadInput(scene.name, guesses[1], None, f"no value together with {guesses[0]}")
    if options.orbit is not None and options.returns is not None:
        raise BadInput(scene.name, "--returns", options.returns, "no --orbit with it")
    if options.pick is not None and options.search is None:
        raise BadInput(scene.name, "--pick", options.pick, "--search, whose orbits it counts")
    if options.file is not None and options.search is not None and options.pick is None:
        raise BadInput(scene.name, "-o", options.file, "--pick, which chooses one orbit")
    _check_place(options)
    if options.search is not None:
        return _search(options, scene)
    return _orbit(options, scene)


def _check_place(options: Namespace) -> None:
    """Whether a certificate can be written, before anything is proved; raises BadInput."""
    if options.file is not None:
        from polhode.certificates import certificate_file

        check_writable(Path(options.file), [".json"], [library.path_of(options.scene)])
        certificate_file.refuse_another(options.file)
        refuse_two_on_stdout(Path(options.file), options.json)


def _orbit(options: Namespace, scene: Scene) -> int:
    from polhode.proofs.prove_orbit import DIGITS, prove_orbit
    from polhode.proofs.refusals import NotProved

    with ProgressLine("prove") as progress:
        try:
            found = prove_orbit(
                scene,
                options.orbit,
                options.digits or DIGITS,
                options.h,
                options.f,
                options.period,
                options.returns,
                progress.say,
                options.tolerance,
            )
        except NotProved as why:
            progress.clear()
            return _refused(why)
    return _one(options, found)


def _chaos(options: Namespace, scene: Scene) -> int:
    from polhode.proofs.chaos.prove_chaos import TRIES, prove_chaos
    from polhode.proofs.refusals import NotProved

    for key in ("digits", "period", "returns", "search", "pick", "tolerance"):
        if getattr(options, key) is not None:
            raise BadInput(scene.name, f"--{key}", getattr(options, key), "with orbit only")
    _check_place(options)
    with ProgressLine("prove") as progress:
        try:
            found = prove_chaos(
                scene,
                options.orbit,
                options.tries or TRIES,
                options.h,
                options.f,
                progress.say,
            )
        except NotProved as why:
            progress.clear()
            return _refused(why)
        if options.file is not None:
            found.save(options.file, progress.show)
    return _told(options, found)


def _told(options: Namespace, found: ProvedChaos) -> int:
    from polhode.output import proofs as output

    alone = options.file is not None and is_stdout(Path(options.file))
    tell = note if alone else say  # a certificate on stdout stands there alone
    if options.json:
        print_json(output.of_chaos(found))
        return DONE
    for line in output.chaos_lines(found):
        tell(line)
    tell(str(found))
    if options.file is not None:
        tell_certificate(found.scene.name, options.file)
    note(f"{found.scene.name}: proved at try {found.tries}, {found.seconds:.2f} s")
    return DONE


def _one(options: Namespace, found: ProvedOrbit) -> int:
    from polhode.certificates.verdict import trusted_base
    from polhode.output import proofs as output

    if options.file is not None:
        found.save(options.file)
    alone = options.file is not None and is_stdout(Path(options.file))
    tell = note if alone else say  # a certificate on stdout stands there alone
    if options.json:
        print_json(output.of_proof(found))
        return DONE
    for line in output.lines(found):
        tell(line)
    tell(str(found))
    if options.file is not None:
        tell_certificate(found.scene.name, options.file)
    note(
        f"{found.scene.name}: every digit is proven; {counted(found.runs, 'run')} of the checker "
        f"at {found.bits} bits, {found.seconds:.2f} s"
    )
    note(trusted_base())
    return DONE


def _refused(why: NotProved) -> int:
    note(f"polhode: not proved: {why}")
    return NOT_REACHED


def _search(options: Namespace, scene: Scene) -> int:
    from polhode.dynamics.periodic_orbits.search import orbit_search
    from polhode.output import orbits
    from polhode.output import proofs as output
    from polhode.proofs.prove_orbit import DIGITS, prove_all, prove_found, tolerance_of
    from polhode.proofs.refusals import NotProved

    grid = read_grid(scene.name, options.search)
    digits, bodies = options.digits or DIGITS, tolerance_of(scene.name, options.tolerance)
    with ProgressLine("prove") as progress:
        found = orbit_search(scene, grid, options.returns, options.h, options.f, progress.say)
        if options.pick is not None:
            if options.pick > len(found.orbits):
                expected = f"a number to {len(found.orbits)}: so many orbits were found"
                raise BadInput(scene.name, "--pick", options.pick, expected)
            try:
                one = prove_found(found, options.pick - 1, digits, progress.say, bodies)
            except NotProved as why:
                progress.clear()
                return _refused(why)
    if options.pick is not None:
        return _one(options, one)
    proofs = prove_all(found, digits, bodies)
    if options.json:
        print_json(orbits.of_search(found) | {"proofs": [output.of_result(one) for one in proofs]})
    else:
        rows = [[str(k), output.line_of(one)] for k, one in enumerate(proofs, 1)]
        print_table(["orbit", "proof"], rows)
    note(f"{scene.name}: {found!r}, {output.count(proofs)}; no list is complete")
    if found.interrupted:
        return INTERRUPTED
    return DONE if output.all_proved(proofs) else NOT_REACHED
