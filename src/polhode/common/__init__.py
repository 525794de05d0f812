"""What every floor needs: errors, whole files, provenance."""
