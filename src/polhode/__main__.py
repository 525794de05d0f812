"""``polhode``, and ``python -m polhode``."""

from typing import NoReturn

from polhode.common.signals import hear


def command() -> NoReturn:
    """The command line, whose signals are heard before the rest is imported."""
    hear()
    from polhode import cli

    cli.command()


if __name__ == "__main__":
    command()
