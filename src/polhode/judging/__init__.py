"""How many digits are correct, how many are expected, and what limits them."""
