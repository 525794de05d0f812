"""Quad digits and more from a run in double, corrected by exact arithmetic.

heyoka runs in double.  Its steps are grouped into intervals; on all of them at once the Gauss
collocation equations are solved to many more digits than a double has: the defect of the present
states is computed exactly, by numbers held as sums of doubles, and the correction, being small, in
plain double.  A few sweeps do.  See :mod:`polhode.refined.refinement` for the front.

No line of this package may be reassociated by a compiler (heyoka's ``fast_math``): sums such as
``(x + c) - c`` are meant.
"""
