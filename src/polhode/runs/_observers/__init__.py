"""Outputs besides the state: attitude, angles."""
