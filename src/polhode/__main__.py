"""``polhode``, and ``python -m polhode``."""

from polhode.common.interrupts import hear


def command() -> None:
    """The command line, whose signals are heard before the rest is imported."""
    hear()
    from polhode import cli

    cli.command()


if __name__ == "__main__":
    command()
