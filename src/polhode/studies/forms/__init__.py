"""What each form of the equations costs."""
