"""Certified digits: balls that contain the exact motion of any body, proven.

A scene and times go in; six balls a time come out, each around the exact value.  Nothing that is
found by approximation is believed: heyoka's run, the series made of it and their corrections
(``approximate``, ``correction``, ``turn_series``) may be wrong in any way and cost digits or a
refusal, never a wrong ball.  The proof rests on ``fixed`` (exact data to integers), ``pieces``,
``digits`` and ``defect`` (what integer polynomials miss, exactly), ``bound`` (the errors of one
step), ``zonotope`` (the set carried from step to step), ``conserved`` (the first integrals shrink
it) and ``polynomial``; python-flint's integers and balls; and IEEE double arithmetic whose rounding
is bounded term by term.

The theorem of one step is in ``bound``, that of the chain in ``zonotope``.  The attitude rests on
``quaternion``, its angles on ``windings`` as well; ``attitude`` puts both into the scene's axes.
"""
