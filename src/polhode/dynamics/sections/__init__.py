"""Sections of a level by many orbits."""
