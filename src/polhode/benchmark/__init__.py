"""The heavy top benchmark: certified values of named tops, and checkers in other languages."""
