"""A closed form at very many times."""
