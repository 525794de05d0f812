"""What is wanted beside the state: attitude, angles, events."""
