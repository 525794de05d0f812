"""All that drives heyoka: steps, events, projection, variations, batches.

:mod:`polhode.taylor.heyoka` alone imports it.
"""
