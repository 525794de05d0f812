"""Event times in ulps, counts, grazing contacts, cost."""
