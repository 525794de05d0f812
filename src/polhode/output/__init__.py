"""What is listed, described, explained: cases, scenes, this installation, the guide."""
