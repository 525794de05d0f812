"""The derived columns of a trajectory, one file each, called as the word in a scene is."""
