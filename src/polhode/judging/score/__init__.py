"""A trajectory held against its reference: the score, and how it reads."""
