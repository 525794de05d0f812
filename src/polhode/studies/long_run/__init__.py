"""Growth of error and drift over long runs, and other programs at one far moment."""
