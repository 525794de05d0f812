"""Results in files and tables: one way for all of them."""
