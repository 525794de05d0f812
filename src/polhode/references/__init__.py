"""Closed forms of the integrable motions: independent evidence, sharing no code with integration."""
