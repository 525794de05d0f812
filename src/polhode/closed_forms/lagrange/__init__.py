"""The symmetric top with its centre of mass on its axis."""
