"""Chaos maps: which motions of a level or of a family are chaotic."""
