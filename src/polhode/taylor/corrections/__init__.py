"""Projection of the running state onto its first integrals."""
