"""Computer-assisted proofs: periodic orbits of exact levels.

What is found by approximation is a guess, corrected by Newton's method and then proved or refused.
A proof rests on ``polhode.enclosures`` and on the modules here that import nothing that
approximates: ``level``, ``flow_tube``, ``krawczyk``, ``periodic_orbit``, ``least_period``.
"""
