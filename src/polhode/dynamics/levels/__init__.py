"""Levels of energy and area: permanent rotations, regions, effective potential."""
