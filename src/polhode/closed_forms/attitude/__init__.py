"""What every closed form needs for the attitude: start, quaternions, counted turns."""
