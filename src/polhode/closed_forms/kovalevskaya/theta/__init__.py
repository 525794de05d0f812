"""Generic motion: theta functions on the Jacobian of the curve, in balls."""
