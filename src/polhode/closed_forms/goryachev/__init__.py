"""Goryachev's motions of 1899."""
