"""The regression of the library: every case, every form, every printed figure."""
