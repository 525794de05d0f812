"""Zeros of polynomials along the exact motion: found, proven, or said to be undecided."""
