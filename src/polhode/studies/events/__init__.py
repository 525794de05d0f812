"""Event times in ulps, counts, cost."""
