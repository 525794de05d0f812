"""Studies: one folder for each (rows, page, figure), and the report made of all of them."""
