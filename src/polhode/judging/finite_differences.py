"""Derivatives of what is known at samples only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def derivative_weights(nodes: Sequence[Any]) -> list[Any]:
    """Weights of the derivative at the middle node of the polynomial through all of them (mpf)."""
    from polhode.numbers.mpmath_context import mpmath

    middle = len(nodes) // 2
    scale = [
        1 / mpmath.fprod(x - y for j, y in enumerate(nodes) if j != i) for i, x in enumerate(nodes)
    ]
    weights = [
        mpmath.mpf(0) if i == middle else scale[i] / scale[middle] / (nodes[middle] - x)
        for i, x in enumerate(nodes)
    ]
    weights[middle] = -mpmath.fsum(weights)
    return weights
