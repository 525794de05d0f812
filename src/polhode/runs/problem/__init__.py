"""A scene made ready for one number type, and what was asked of its run."""
