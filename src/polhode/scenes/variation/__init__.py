"""Variation of a scene's numbers: keys, scenes, and their numbers in columns."""
