"""Periodic orbits and chaos, proved or refused."""
