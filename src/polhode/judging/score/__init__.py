"""A trajectory compared with its reference: the score, and its text."""
