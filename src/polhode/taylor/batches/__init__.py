"""Many motions of doubles at once, one in each SIMD lane."""
