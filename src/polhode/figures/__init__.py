"""Figures of motions and of results, films and pages that move: one file per kind.

matplotlib is imported here and in the studies' figures.
A figure is ``draw(pyplot, samples)``, which :func:`polhode.figures.catalogue.drawn` turns into
bytes.
"""
