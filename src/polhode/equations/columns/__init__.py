"""The derived columns of a trajectory, one file each, named by the word in a scene."""
