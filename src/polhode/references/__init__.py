"""Closed forms of the integrable motions: evidence that shares no code with integration."""
