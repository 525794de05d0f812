"""Periodic orbits: found, refined to any digits, continued in families."""
