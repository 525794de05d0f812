"""Closed forms of the solvable tops: independent evidence, a file or a folder per family."""
