"""All that imports heyoka: steps, events, projection, variations, batches."""
