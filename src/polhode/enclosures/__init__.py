"""Certified digits: balls that contain the exact motion of any body, proven.

A scene and times go in; six balls a time come out, each around the exact value.  Nothing that is
found by approximation is believed: what ``approximation`` makes, the engine's run, the series of it
and their corrections, may be wrong in any way and cost digits or a refusal, never a wrong ball.
The proof rests on the other modules: ``fixed_point_problem`` (exact data to integers),
``taylor_polynomials`` (what integer polynomials miss, exactly), ``step_bound`` (the errors of one
step), ``zonotope`` (the set carried from step to step), ``integral_contraction`` (the first
integrals shrink it) and ``polynomial``; on python-flint's integers and balls; and on IEEE double
arithmetic whose rounding is bounded term by term.

The theorem of one step is in ``step_bound``, that of the chain in ``zonotope``.  The attitude rests
on ``quaternion``, and ``attitude`` puts it into the scene's axes; its angles are proven up to whole
turns.  Events are zeros of polynomials, ``zeros``.  ``task`` holds what states and events are asked
for alike: times, digits, limits, the precision.
"""
