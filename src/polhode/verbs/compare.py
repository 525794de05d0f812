"""``polhode compare``: judge a trajectory that some other program computed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.output import results
from polhode.scenes import library
from polhode.verbs.terminal import DONE, print_json, print_table, whole

HELP = "judge a trajectory that some other program computed"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("file", metavar="FILE", help="a CSV with a column t and any of the others")
    parser.add_argument("scene", metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--number", help="the file's decimals are rounded values of this type")
    parser.add_argument("--digits", type=whole, help="digits of mp, with --number mp")


def main(options: Namespace) -> int:
    """Judge a trajectory that some other program computed."""
    from polhode.judging import foreign
    from polhode.judging import table as table_
    from polhode.judging.judgement import few
    from polhode.judging.limits import shown_digits, shown_possible
    from polhode.judging.reference import reference as truth_of
    from polhode.runs.request import choose_number

    scene = library.load(options.scene)
    number = None
    if options.number is not None:
        number = choose_number(scene, options.number, options.digits)
    table = table_.read_table(Path(options.file), number)
    verdict = foreign.judge(table, truth_of(scene), number)
    answer = results.of_verdict(verdict)
    if options.json:
        print_json(answer)
        return DONE
    truth = verdict.reference
    print(f"{table.name} against {truth.kind} of {scene.name} ({truth.regime})")
    if verdict.digits:
        shown_rows = few(len(verdict.digits), 11)
        possible = verdict.digits_possible
        rows = [
            [
                answer["times"][k],
                shown_digits(verdict.digits[k], possible[k]),
                shown_possible(possible[k]),
            ]
            for k in shown_rows
        ]
        print_table(["t", "correct digits", f"possible in {verdict.yardstick.name}"], rows)
        if len(rows) < len(verdict.digits):
            print(f"({len(rows)} of {len(verdict.digits)} times; all of them with --json)")
        assert verdict.worst_time is not None
        worst = f"worst {verdict.worst:.2f} correct digits at t = {float(verdict.worst_time):g}"
        print(f"{verdict.lost or worst}; limited by {verdict.limit}")
    print(f"motion {verdict.motion}")
    for name, digits in verdict.parts.items():
        print(f"{name}: {digits:.2f} correct digits")
    if verdict.omega_alone is not None:
        print(verdict.omega_alone)
    if answer["drift"] is not None:
        print("drift " + ", ".join(f"{k} {v}" for k, v in answer["drift"].items() if v))
    for note in verdict.notes:
        print(f"not judged: {note}")
    return DONE
