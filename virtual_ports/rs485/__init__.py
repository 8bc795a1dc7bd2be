"""RS485 segments: wires that stations share, in simulated time.

``segment.py`` is the wire, ``stations.py`` its stations, ``disturbance.py`` the reading of bursts that
overlap.

May import: hil.vocab, hil.wire, the pure standard library.
"""
