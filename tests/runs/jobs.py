"""Jobs for other processes, which import this file alone, and little with it."""

import os
import sys


def squared(k):
    if k == 3:
        raise ValueError(f"no {k}")
    return k * k


class Odd(Exception):
    """Pickled, but not made again from what is pickled."""

    def __init__(self, one, two):
        super().__init__(f"{one} {two}")


def odd(k):
    raise Odd("odd", k)


def unspeakable(k):
    return lambda: k


def noisy(k):
    print("what a library says")
    os.write(1, b"and what its C code says")
    return sys.stdin.read(), k
