"""All that drives heyoka: steps, events, projection, variations, batches.

:mod:`polhode.taylor.backend.engine` alone imports it.
"""
