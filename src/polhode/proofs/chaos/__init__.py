"""The search for a certificate of chaos: a homoclinic orbit, and charts and sets along it.

Nothing here is trusted: ``certificates/verify.py`` proves or refuses what is found.
"""
