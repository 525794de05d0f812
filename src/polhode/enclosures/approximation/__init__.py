"""Guesses that guide a proof and are not trusted: approximate motions, corrections, costs."""
