"""``polhode reference``: the closed form alone, or a proven enclosure of any motion."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput
from polhode.numbers import number_types
from polhode.numbers.exact import Exact
from polhode.output import results
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.verbs.terminal import (
    DONE,
    Progress,
    note,
    print_json,
    print_rows,
    read_times,
    whole,
)

HELP = "the closed form alone, or a proven enclosure of any motion"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--at", metavar="T,T...", help="times instead of the scene's")
    parser.add_argument("--digits", type=whole, default=50, help="correct digits (50)")
    parser.add_argument(
        "--certified",
        action="store_true",
        help="a proven enclosure, of any motion: only proven digits are printed",
    )


def main(options: Namespace) -> int:
    """The closed form alone, or the enclosure."""
    from polhode.judging.reference import Reference
    from polhode.judging.reference import reference as reference_of

    scene = library.load(options.scene)
    times = scene.times if options.at is None else read_times(scene, options.at)
    if not times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    if not 1 <= options.digits <= number_types.MAX_DIGITS:
        expected = f"1 to {number_types.MAX_DIGITS}"
        raise BadInput(scene.name, "digits", options.digits, expected)
    if options.certified:
        return _certified(scene, times, options)
    reference = reference_of(scene)
    if not isinstance(reference, Reference):
        expected = "a scene with a closed form, or --certified"
        raise BadInput(scene.name, "reference", reference.regime, expected)
    answer = results.of_reference(reference, times, options.digits)
    if options.json:
        print_json(answer)
    else:
        print_rows(answer)
    return DONE


def _certified(scene: Scene, times: tuple[Exact, ...], options: Namespace) -> int:
    """A proven enclosure; on stdout nothing but proven digits."""
    from polhode.enclosures.certify import certify

    held = results.held_times(scene, times, options.digits)
    with Progress("reference") as progress:
        found = certify(scene, held, options.digits, progress=progress.show)
    answer = results.of_enclosure(found)
    if options.json:
        print_json(answer)
        return DONE
    print_rows(answer)
    note(
        f"{scene.name}: every digit is proven, at least {found.proven:.1f} at each time; "
        f"{found.steps} steps at a noise level of 2**-{found.noise}, {found.seconds_in_all:.1f} s"
    )
    return DONE
