"""Zeros of polynomials along the exact motion: found, and proven or undecided."""
