"""Special functions that the closed forms share, to any precision."""
