"""The methods that integrate a system: Taylor steps, and refined ones."""
