"""The verbs of the command line: one file a verb.

Each has ``HELP``, ``options(parser)`` for its own options, and ``main(options)``, which returns an
exit code.
"""
