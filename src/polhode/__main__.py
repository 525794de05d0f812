"""``python -m polhode``."""

from polhode.cli import command

command()
