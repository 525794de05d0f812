"""The verbs of the command line.

Each is a row of :mod:`polhode.verbs.catalogue`.  Most are functions, and
:mod:`polhode.verbs.deliver` is the one way out for their results.  The others (``new``, ``plot``,
``view``, ``guide``) are functions of the verb's options that return an exit code, beside one that
adds these options, such as ``add_new``.
"""
