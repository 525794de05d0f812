"""Derivatives of the flow along an enclosed motion."""
