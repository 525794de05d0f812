"""What a motion makes of errors: amplification, rounding, Lyapunov's exponent."""
