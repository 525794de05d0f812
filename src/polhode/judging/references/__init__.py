"""What a trajectory is judged against: closed form, enclosure."""
