"""Hess and Appelrot's case: motions on the surface Iw.r0 = 0."""
