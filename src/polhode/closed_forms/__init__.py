"""Closed forms of the solvable tops: independent evidence, one folder per family."""
