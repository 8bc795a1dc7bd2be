"""Runs of a bench in real time: which wait, which move, and what became of them.

``queue.py`` has them all. ``lead.py`` leads a run that spans benches, ``part.py`` is this bench's part of one
that another leads, ``names.py`` tells axes of several benches apart. ``real.py`` lets real boards take part.
What a run is and what follows from it stands in ``hil.runs``.
"""
