"""The running state put back on its first integrals."""
