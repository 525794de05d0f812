"""One file a form of the equations."""
