"""Any heavy body that swings about a horizontal principal axis."""
