"""Families with one orbit per body, each in one file."""
