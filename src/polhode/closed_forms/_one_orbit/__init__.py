"""Families with one orbit a body, each in one file."""
