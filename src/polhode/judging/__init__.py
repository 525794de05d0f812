"""How many digits are right, how many are to be expected, and what limits them."""
