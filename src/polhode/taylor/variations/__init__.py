"""What becomes of small changes along a motion: variational equations."""
