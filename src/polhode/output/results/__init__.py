"""Results in files and tables: one mechanism for all of them."""
