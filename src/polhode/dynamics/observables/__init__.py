"""Sweeps of which some numbers a member are kept."""
