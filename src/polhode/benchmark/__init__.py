"""The heavy top benchmark: certified values and certificates, and checkers in other languages."""
