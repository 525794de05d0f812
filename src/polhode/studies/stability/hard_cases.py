"""The hard cases by what is hard about them: names of cases that ship."""

from __future__ import annotations

KINDS: dict[str, tuple[str, ...]] = {
    "Flips from next to the middle axis": (
        "hard/dzhanibekov-1e-3",
        "euler/dzhanibekov",
        "hard/dzhanibekov-1e-9",
        "hard/dzhanibekov-1e-12",
    ),
    "Exact separatrices": (
        "euler/separatrix",
        "euler/separatrix-backward",
        "euler/separatrix-irrational",
        "lagrange/homoclinic",
        "lagrange/planar-separatrix",
        "pendulum/separatrix",
    ),
    "Next to a separatrix": (
        "euler/near-separatrix",
        "hard/near-homoclinic",
        "hard/complementary-modulus-1e-40",
    ),
    "Nearly equal moments": ("euler/nearly-symmetric", "hard/nearly-symmetric-heavy"),
    "Spin about its critical value": (
        "lagrange/sleeping-critical",
        "hard/sleeping-above-critical-spin",
        "hard/sleeping-below-critical-spin",
        "hard/tilted-critical-spin",
        "hard/tilted-above-critical-spin",
        "hard/tilted-below-critical-spin",
        "hard/near-steady",
    ),
    "Cusps": ("lagrange/cusped", "hard/near-cusp"),
    "Next to a solvable case": (
        "hard/near-bobylev-steklov-asymmetric",
        "hard/near-chaplygin",
        "hard/near-goryachev-chaplygin",
        "hard/near-goryachev",
        "hard/near-grioli",
        "hard/near-hess",
        "hard/near-n-kowalewski",
        "hard/near-staude",
        "hard/near-steklov",
    ),
    "Through a pole or past it": (
        "lagrange/upper-pole",
        "lagrange/lower-pole",
        "lagrange/from-the-pole",
        "hard/near-pole",
        "published/bruels-cardona-arnold",
    ),
    "Next to degenerate motions of the Kovalevskaya top": (
        "kovalevskaya/near-delaunay",
        "hard/near-appelrot",
        "hard/near-bobylev-steklov",
        "hard/near-asymptotic",
        "hard/near-quasi-periodic",
        "hard/near-multiply-degenerate",
        "hard/near-axial-pendulum",
        "hard/near-equatorial-pendulum",
    ),
    "Fast spin": ("euler/fast-spin", "hard/fast-top", "hard/very-fast-top"),
    "Units that make the numbers huge or tiny": (
        "euler/huge-units",
        "euler/tiny-units",
        "hard/heavy-huge-units",
        "hard/heavy-tiny-units",
    ),
    "Needle and flat body": ("euler/needle", "euler/flat"),
    "Unstable equilibria and permanent rotations": (
        "euler/permanent-middle",
        "euler/turned-permanent",
        "lagrange/sleeping-unstable",
        "pendulum/upright",
        "hard/staude",
    ),
    "Chaotic and falling bodies": (
        "general/asymmetric-chaotic",
        "hard/chaotic-long",
        "general/near-upright",
    ),
    "A million units of time": ("hard/million",),
}

QUICK = (
    "euler/dzhanibekov",
    "euler/separatrix",
    "hard/near-homoclinic",
    "hard/near-pole",
    "hard/heavy-tiny-units",
    "hard/sleeping-below-critical-spin",
)


def names(quick: bool = False) -> list[str]:
    """All hard cases, or the few of a quick study."""
    return [name for cases in KINDS.values() for name in cases if not quick or name in QUICK]
