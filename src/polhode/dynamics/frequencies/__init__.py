"""Frequencies of a motion from its samples."""
