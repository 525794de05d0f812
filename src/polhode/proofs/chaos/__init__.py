"""Chaos on a level: covering relations along a homoclinic orbit.

``lanes``, ``homoclinic`` and ``chain_candidate`` guess; ``h_set``, ``transit``, ``covering`` and
``theorem`` are trusted, and import nothing that approximates.
"""
