"""Figures as SVG text, one file a study; the only place that imports matplotlib.

A study's figure is ``svg(found) -> str``, made from the study's JSON object alone.
"""
