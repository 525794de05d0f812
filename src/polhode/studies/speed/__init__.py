"""Error against seconds, beside other programs."""
