"""Results as JSON, CSV and NPZ; names and shapes are a contract."""
