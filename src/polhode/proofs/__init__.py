"""Computer-assisted proofs: periodic orbits and chaos of exact levels.

What is found here is a guess, and becomes a certificate in memory; ``certificates/verify.py``, a
file that imports nothing of polhode, proves or refuses it.
"""
