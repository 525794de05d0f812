"""Turns of psi and phi: all counting that families share."""
