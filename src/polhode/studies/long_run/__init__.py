"""Growth of error and drift over long runs."""
