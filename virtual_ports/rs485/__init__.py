"""RS485 segments: a wire that stations share, in simulated time.

``segment.py`` is the wire, ``stations.py`` who is on it, ``disturbance.py`` what bursts that overlap read as.

May import: hil.vocab, hil.wire, the pure standard library.
"""
