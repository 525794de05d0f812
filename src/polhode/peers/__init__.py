"""Other programs on the same equations: one small driver a peer, each run as a process of its own.

``python -m polhode.peers.NAME < job.json`` reads a job and writes one line of JSON an answer, see
:mod:`polhode.peers.protocol`.  A driver imports nothing of polhode but its neighbours here, so that
its process pays for its own imports alone.  The peers come with ``pip install 'polhode[peers]'``
(numbalsoda, which needs a Fortran compiler, with ``polhode[peers-fortran]``).
"""
