"""What is listed, described and explained: cases, scenes, this installation, the guide, notebooks."""
