"""The methods that integrate a problem: Taylor steps, and refined ones."""
