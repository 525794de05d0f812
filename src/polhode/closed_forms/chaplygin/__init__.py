"""Chaplygin's motions of 1904."""
