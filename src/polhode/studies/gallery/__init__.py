"""The study gallery: motions worth knowing, each with its picture."""
