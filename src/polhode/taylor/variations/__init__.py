"""Variational equations: small changes along a motion."""
