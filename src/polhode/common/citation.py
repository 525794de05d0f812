"""How polhode is cited: CITATION.cff and ``polhode about --cite`` are made of this."""

from __future__ import annotations

from polhode.common.provenance import __version__

TITLE = "polhode: the heavy rigid body about a fixed point, with proven digits"
AUTHORS = "The polhode founders"
RELEASED = "2026-11-28"


def bibtex() -> str:
    """Entries for a bibliography: polhode, and heyoka, which it integrates with."""
    year = RELEASED[:4]
    return f"""\
@software{{polhode,
  author  = {{{{{AUTHORS}}}}},
  title   = {{{TITLE}}},
  version = {{{__version__}}},
  date    = {{{RELEASED}}},
  year    = {{{year}}}
}}

@article{{heyoka,
  author  = {{Biscani, Francesco and Izzo, Dario}},
  title   = {{Revisiting high-order Taylor methods for astrodynamics and celestial mechanics}},
  journal = {{Monthly Notices of the Royal Astronomical Society}},
  volume  = {{504}},
  number  = {{2}},
  pages   = {{2614--2628}},
  year    = {{2021}},
  doi     = {{10.1093/mnras/stab1032}}
}}
"""


def cff() -> str:
    """The file CITATION.cff (citation-file-format.github.io, 1.2.0)."""
    return f"""\
cff-version: 1.2.0
message: "If you use polhode, please cite it as below, and heyoka, which it integrates with."
title: "{TITLE}"
type: software
authors:
  - name: "{AUTHORS}"
version: {__version__}
date-released: {RELEASED}
license: MIT
keywords:
  - "rigid body dynamics"
  - "Euler-Poisson equations"
  - "Taylor method"
  - "validated numerics"
references:
  - type: article
    title: "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics"
    authors:
      - family-names: "Biscani"
        given-names: "Francesco"
      - family-names: "Izzo"
        given-names: "Dario"
    journal: "Monthly Notices of the Royal Astronomical Society"
    volume: 504
    issue: 2
    start: 2614
    end: 2628
    year: 2021
    doi: "10.1093/mnras/stab1032"
  - type: book
    title: "Rigid Body Dynamics: A Lagrangian Approach"
    authors:
      - family-names: "Yehia"
        given-names: "Hamad M."
    publisher:
      name: "Birkhäuser"
    year: 2022
"""
