"""The verbs of the command line.

Most are functions with a row of :mod:`polhode.verbs.catalogue`, and :mod:`polhode.verbs.deliver` is
the one way out for their results.  The others have a file each, with ``HELP``, ``options(parser)``
for their own options, and ``main(options)``, which returns an exit code.
"""
