"""One integrator of a system: specified, built, stepped."""
