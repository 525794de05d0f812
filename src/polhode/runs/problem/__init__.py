"""A scene prepared for one number type, and the options of its run."""
