"""Sweeps that keep some numbers of each member."""
