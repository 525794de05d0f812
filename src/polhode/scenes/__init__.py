"""The task: body, start, times; scene files, the case library, variation of numbers."""
