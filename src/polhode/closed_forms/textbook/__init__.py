"""The three classical tops by mpmath's own functions, as textbooks have them.

A second reference, which shares no formula, no arithmetic and no way to reach its precision with
the closed forms in balls: Jacobi's functions, Carlson's integral, quadratures and Newton's method
are mpmath's or are written here.  It takes from polhode the scene's numbers and the name of the
regime, nothing else.
"""
