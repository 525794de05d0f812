"""Crossings and contacts of expressions along a motion."""
