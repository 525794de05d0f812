"""``polhode reference``: the closed form alone, no integration."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput
from polhode.numbers import number_types
from polhode.output import results
from polhode.scenes import library
from polhode.verbs.terminal import DONE, print_json, print_rows, read_times, whole

HELP = "the closed form alone, no integration"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--at", metavar="T,T...", help="times instead of the scene's")
    parser.add_argument("--digits", type=whole, default=50, help="correct digits (50)")


def main(options: Namespace) -> int:
    """The closed form alone."""
    from polhode.judging.reference import Reference
    from polhode.judging.reference import reference as reference_of

    scene = library.load(options.scene)
    times = scene.times if options.at is None else read_times(scene, options.at)
    if not times:
        raise BadInput(scene.name, "run.end", None, "given, or times asked for with --at")
    if not 1 <= options.digits <= number_types.MAX_DIGITS:
        expected = f"1 to {number_types.MAX_DIGITS}"
        raise BadInput(scene.name, "digits", options.digits, expected)
    reference = reference_of(scene)
    if not isinstance(reference, Reference):
        raise BadInput(scene.name, "reference", reference.regime, "a scene with a closed form")
    answer = results.of_reference(reference, times, options.digits)
    if options.json:
        print_json(answer)
    else:
        print_rows(answer)
    return DONE
