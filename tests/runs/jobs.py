"""Jobs for other processes, which import this file alone, and little with it."""

import os
import sys
import time

PARENT, MARK = "POLHODE_TEST_PARENT", "POLHODE_TEST_MARK"


def squared(k):
    if k == 3:
        raise ValueError(f"no {k}")
    return k * k


def deadly(k):
    """Ends a process that the first one began, and leaves a mark."""
    if os.getppid() == int(os.environ[PARENT]):
        os.close(os.open(os.environ[MARK], os.O_CREAT))
        os._exit(1)
    return -k


def long(k):
    if k:
        time.sleep(600)
    return k


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
