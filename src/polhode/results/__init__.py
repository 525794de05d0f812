"""Results: what they tell of themselves, and how that is written to files and read again."""
