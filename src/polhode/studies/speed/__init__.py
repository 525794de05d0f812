"""Seconds against digits, beside other programs and in every number type."""
