"""A scene and a number type to a trajectory: one, many, at any time."""
