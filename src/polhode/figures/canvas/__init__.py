"""What figures share: the canvas, labels, curves, scales."""
