"""What every family shares: axes, precision, attitude, angles."""
