"""Zeros of expressions along a motion: found, refined, separated."""
