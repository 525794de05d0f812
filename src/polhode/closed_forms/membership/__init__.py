"""Which scenes belong to a family of closed forms, and why others do not."""
