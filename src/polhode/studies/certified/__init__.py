"""Study ``certified``: what is proven, how far, and at what price."""
