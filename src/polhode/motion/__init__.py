"""The frame, the interface and the results of a motion: its end, its events, its corrections."""
