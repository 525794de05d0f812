"""How many digits are right, how many are possible, and what limits them."""
