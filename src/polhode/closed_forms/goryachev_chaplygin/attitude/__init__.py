"""The attitude of Goryachev and Chaplygin's case."""
