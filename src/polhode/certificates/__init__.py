"""Certificates of proofs, and a program that checks them alone."""
