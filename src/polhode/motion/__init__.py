"""What a motion under way leaves behind: how it ended, its events, its corrections."""
