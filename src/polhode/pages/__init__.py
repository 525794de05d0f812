"""Pages of the report, one file a study: the study's JSON object to blocks of text and tables.

A study's page is ``TITLE`` and ``blocks(found) -> Iterator[Block]``; Markdown and HTML are made
from the same blocks, and a number in them is never edited by hand.
"""
