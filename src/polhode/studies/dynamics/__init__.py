"""Levels, sections and a chaos map of six bodies, and what a section costs elsewhere."""
