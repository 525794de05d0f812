"""What figures share: the canvas, panels of series, labels, curves, scales."""
