"""Studies: one file a study, cases and methods to rows of results."""
