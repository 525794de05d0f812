"""Numbers of a scene varied: which, the scenes, and their numbers in columns."""
