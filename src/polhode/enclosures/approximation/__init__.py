"""What proofs are guided by and believe nothing of: approximate motions, corrections, costs."""
