"""Trajectories of any origin as tables of exact numbers."""
