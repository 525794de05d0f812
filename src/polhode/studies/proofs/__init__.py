"""Periodic orbits and chaos, proved."""
