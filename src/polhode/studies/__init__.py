"""Studies: one folder a study (rows, page, figure), and the report made of all of them."""
