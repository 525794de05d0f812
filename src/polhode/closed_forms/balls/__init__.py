"""Closed forms in FLINT's balls: every number comes with a proven bound of its error."""
