"""Correct digits of every case in every number type."""
