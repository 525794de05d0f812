"""Figures, one file a study or a kind of motion's figure; the only place that imports matplotlib.

A study's figure is ``svg(found) -> str``, made from the study's JSON object alone; a motion's is
``draw(pyplot, samples)``, which :func:`polhode.figures.canvas.drawn` turns into bytes.
"""
