"""heyoka's numbers, options and pool: all that is not an integrator."""
