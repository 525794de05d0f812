"""Bobylev and Steklov's motions."""
