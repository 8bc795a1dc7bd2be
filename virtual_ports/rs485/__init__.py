"""RS485 segments: a wire that stations share. Pure: simulated time is an argument.

``segment.py`` is the wire, ``stations.py`` who is on it, ``disturbance.py`` what bursts that overlap read as.
"""
