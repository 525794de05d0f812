"""Other programs on the same equations: a small module a peer, which imports nothing but these.

``prepared(present, method)`` gives the peer as a function of body, start, times and tolerance
(:mod:`polhode.peers.prepared`).  A process of its own runs it for the study of long runs and for
first results: ``python -m polhode.peers.process < job.json``.  The peers come with ``pip install
'polhode[peers]'`` (numbalsoda, which needs a Fortran compiler, with ``polhode[peers-fortran]``).
"""
