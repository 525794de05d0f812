"""Methods of fixed steps whose order is known, of ``f(t, y)`` without t."""

from __future__ import annotations


def euler(f, y, h):
    return y + h * f(0, y)


def midpoint(f, y, h):
    return y + h * f(0, y + h / 2 * f(0, y))


def rk4(f, y, h, last=6.0):
    a = f(0, y)
    b = f(0, y + h / 2 * a)
    c = f(0, y + h / 2 * b)
    return y + h / last * (a + 2 * b + 2 * c + f(0, y + h * c))
