"""Programs that are not run here: what others measured of rigid bodies with them, as it was read.

None of it was measured for this report.  A figure is told with the problem it belongs to and the
place where it stands; where a source has a drawing and no number, the row says so.
"""

from __future__ import annotations

from typing import NamedTuple


class Read(NamedTuple):
    """What was read of one program.

    ``language``: what it is written in.  ``figure``: as the source has it.  ``source``: the place.
    """

    program: str
    language: str
    problem: str
    figure: str
    source: str


READ = (
    Read(
        "Kynema, Lie-group generalised-alpha",
        "C++",
        "the heavy top of Bruels, Cardona and Arnold to t = 2 in 10 000 steps of 2e-4",
        "largest error of position and attitude 2.05e-4, against a run with steps of 2e-6, which "
        "itself is off by 1.2e-6 from the closed form (see published)",
        "kynema/kynema, tests/regression_tests/regression/verification/dynamic_heavy_top.cpp: "
        "the comment above its tolerance",
    ),
    Read(
        "Drake, RungeKutta3Integrator at accuracy 1e-3",
        "C++",
        "a free symmetric cylinder, w = (2, 4, 6), for four periods or ten seconds",
        "allowed error against the closed form 1e-3 (1 + 1024 t/end), of w twice that",
        "RobotLocomotion/drake, multibody/benchmarks/free_body/test/"
        "multibody_plant_free_body_test.cc",
    ),
    Read(
        "Orekit, TorqueFree (Jacobi's closed form)",
        "Java",
        "free bodies of moments 3/8, 1/2, 5/8, |w| = 0.064, 40 s ahead and back",
        "direction of the momentum kept to 1.6e-15",
        "CS-SI/Orekit, src/test/java/org/orekit/attitudes/TorqueFreeTest.java, testMomentum",
    ),
    Read(
        "OrdinaryDiffEq.jl: DP5, Tsit5, Vern6 and others",
        "Julia",
        "Euler's equations with a torque sin²t/4 about the third axis, to t = 10",
        "drawings of error against seconds, no number in what was read; absolute tolerances 1e-6 "
        "to 1e-13, the reference being Vern7 at 1e-14",
        "docs.sciml.ai, SciMLBenchmarksOutput, NonStiffODE/RigidBody_wpd",
    ),
    Read(
        "integrators by Jacobi's functions",
        "–",
        "a rigid body over many steps, conservation of its integrals",
        "no number in what was read: written plainly, rounding adds up in proportion to time, "
        "where a random walk is possible",
        "G. Vilmart, Reducing round-off errors in rigid body dynamics: abstract and introduction",
    ),
)
