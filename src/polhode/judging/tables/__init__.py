"""Trajectories of any origin as tables of exact numbers, and what may be wrong with them."""
