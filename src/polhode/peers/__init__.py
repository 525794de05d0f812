"""Other programs on the same equations: a small module a peer, which imports nothing but these.

``prepared(present, method)`` gives the peer as a function of body, start, times and tolerance
(:mod:`polhode.peers.prepared`).  Those that the study of long runs asks are processes of their own,
too: ``python -m polhode.peers.NAME < job.json`` reads a job and writes one line of JSON an answer
(:mod:`polhode.peers.protocol`).  The peers come with ``pip install 'polhode[peers]'`` (numbalsoda,
which needs a Fortran compiler, with ``polhode[peers-fortran]``).
"""
