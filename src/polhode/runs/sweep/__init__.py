"""Many motions of one scene whose numbers vary."""
