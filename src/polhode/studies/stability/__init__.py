"""Hard motions: correct digits beside those possible."""
