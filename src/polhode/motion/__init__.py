"""What a motion under way is asked and leaves behind: its end, its events, its corrections."""
