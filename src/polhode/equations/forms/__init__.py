"""The forms of the equations, one file each."""
