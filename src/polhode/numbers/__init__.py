"""Exact numbers, number types, one parser, lossless conversions, decimals."""
