"""The verbs of the command line: one file per verb.

Each has ``HELP``, ``options(parser)`` for its own options, and ``main(options)``, which returns an
exit code.
"""
