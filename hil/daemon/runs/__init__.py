"""Runs of the daemon: which wait, which move, and what became of them.

``runs.py`` has them all. ``together.py`` leads a run that spans benches, ``parts.py`` is this bench's part of
one that another leads. ``real_axes.py`` lets real boards take part. What a run is and what follows from it
stands in ``hil.runs``. Imports no other room of the daemon.
"""
