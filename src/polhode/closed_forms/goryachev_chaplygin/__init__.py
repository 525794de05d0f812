"""Goryachev and Chaplygin's case with f = 0: every motion in closed form."""
