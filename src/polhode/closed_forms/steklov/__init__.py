"""Steklov's motions of 1899."""
