"""heyoka's numbers, options and pools: all that is not an integrator."""
