"""How a motion multiplies errors: amplification, rounding, Lyapunov's exponent."""
