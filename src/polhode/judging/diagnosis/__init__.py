"""What may be wrong with a trajectory: conventions, rounded times, missing columns."""
