"""Grioli's regular precession."""
