"""N. Kowalewski's motions."""
