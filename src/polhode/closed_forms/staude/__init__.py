"""Permanent rotations: Staude's, and rest."""
