"""More cases of what tests try: checks of test files with larger numbers, minutes to hours each.

    python tests/campaigns/more_cases.py [NAME...]

runs the campaigns below that are named, or lists them where none is; ``all`` is all of them.  Each
prints how long it took, or the fault; the exit code is 1 where there was one.

Last printed, of one of them:

    moved data: no fault, 6 s of the processor
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
import traceback
from pathlib import Path

import mpmath

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS), str(TESTS.parent / "reports")]

#: By name the module, and a call in it, which fails where a check does.
CAMPAIGNS = {
    "bands": (
        "judging/test_rounding_errors",
        "of_two_hundred_tops_85_to_95_percent_end_in_the_band()",
    ),
    "benchmark": (
        "reports/test_benchmark",
        "[(tmp_path / x).mkdir()"
        " or certificates_are_made_again_to_the_bit_and_proved(x, tmp_path / x)"
        " for x in [*NAMED][:16]]",
    ),
    "changed chaos certificates": (
        "certificates/test_mutated_chaos",
        "[a_thousand_changed_certificates_prove_nothing_false(kind, first)"
        " for kind in KINDS for first in range(0, 168, 8)]",
    ),
    "changed stability certificates": (
        "certificates/test_stability_certificate",
        "test_drawn_changes_of_a_certificate_prove_nothing_false(certificate(), 500)",
    ),
    "chaos maps": (
        "dynamics/test_chaos_map",
        "[test_verdicts_of_known_motions(*row, (24, 20), 20_000, 460, most) for *row, most in"
        ' [("momentum", "max", 60), ("momentum", "min", 65), ("height", "max", 60)]]',
    ),
    "contest": ("reports/test_contest", "a_small_contest_of_many_starts_from_end_to_end()"),
    "drifting files": ("judging/test_conventions", "drifting_files_are_named_right()"),
    "enclosed attitudes": (
        "enclosures/test_attitude",
        "test_random_tops_have_their_attitude_and_angles_inside(10 * trials.KINDS)",
    ),
    "enclosed closed forms": (
        "enclosures/test_containment",
        "[every_closed_form_lies_in_its_enclosure(digits) for digits in (10, 16, 30)]",
    ),
    "enclosed events": ("enclosures/test_certified_zeros", "test_random_events_are_heyokas(330)"),
    "enclosed tops": (
        "enclosures/test_containment",
        "test_random_tops_are_contained_and_no_radius_is_slack(700, (45, 76, 90, 126))",
    ),
    "faulty parts": (
        "enclosures/test_containment",
        "test_no_fault_in_an_untrusted_part_makes_a_wrong_enclosure(2000)",
    ),
    "far certificates": (
        "certificates/test_stored_certificates",
        "[a_motion_that_is_certified_far_has_a_certificate(name, tmp_path) for name in"
        ' ("general/asymmetric-regular", "lagrange/nutation", "kovalevskaya/generic")]',
    ),
    "growing motions": (
        "dynamics/test_chaos_map",
        "growing_motions_that_are_known_are_unstable_and_others_chaotic()",
    ),
    "loose rows": (
        "runs/test_loose_propagator",
        "rows_of_random_times_are_within_the_tolerance(1000)",
    ),
    "moved data": (
        "closed_forms/test_membership",
        "[test_any_datum_moved_by_1e_30_is_refused(x, slice(1, None, 2)) for x in FIXED]",
    ),
    "numbers of steps": (
        "enclosures/test_hidden_terms",
        "test_no_number_of_a_step_is_below_its_exact_value("
        "3 * trials.KINDS, (36, 42, 60, 79, 126, 226))",
    ),
    "pairs of verbs": (
        "test_all_at_once",
        "[test_pairs_of_verbs_in_threads_answer_as_alone((a, b), None)"
        " for a in VERBS for b in VERBS if a < b]",
    ),
    "scatter of exponents": (
        "dynamics/test_known_stability",
        "the_exponents_of_neighbours_scatter_as_the_uncertainty_says()",
    ),
    "scatter of members": (
        "dynamics/test_reduce_many",
        "exponents_of_chaotic_members_scatter_as_their_uncertainties_say()",
    ),
    "spin on average": (
        "taylor/test_integral_projection",
        "the_spin_of_a_symmetric_body_is_exact_on_average()",
    ),
    "starts of families": (
        "closed_forms/test_balls_of_starts",
        "[test_every_ball_holds_its_value(family, seed)"
        " for family, row in ROUGH.items() for seed in range(row[2])]",
    ),
    "true returns": (
        "proofs/test_prove_stability",
        "[test_rotation_and_twist_are_those_of_true_returns(name) for name in KNOWN]",
    ),
    "windows of events": (
        "taylor/test_event_windows",
        "[runs_meet_what_is_proven_of_very_many_expressions(part) for part in range(10)]",
    ),
}


def run(name: str) -> None:
    """Run one; an AssertionError says what failed."""
    path, call = CAMPAIGNS[name]
    folder, _, module = path.rpartition("/")
    sys.path.insert(0, str(TESTS / folder))
    scope = vars(importlib.import_module(module))
    with tempfile.TemporaryDirectory() as place, mpmath.workprec(6000):
        eval(call, scope | {"tmp_path": Path(place)})


def main(*names: str) -> int:
    """Run those that are named."""
    if not names:
        print(*CAMPAIGNS, sep="\n")
    faults = 0
    for name in CAMPAIGNS if names == ("all",) else names:
        began = time.process_time()
        try:
            run(name)
            print(
                f"{name}: no fault, {time.process_time() - began:.0f} s of the processor",
                flush=True,
            )
        except AssertionError:
            faults += 1
            print(f"{name}: FAULT\n{traceback.format_exc()}", flush=True)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
