"""RS485 segments: wires that stations share, in simulated time.

``bus_kind.py`` is what hil asks this folder for; ``segment.py`` is the wire, ``stations.py`` its stations,
``disturbance.py`` the reading of bursts that overlap.

It knows characters, drivers, collisions and times; what a packet is it asks a ``hil.vocab.framing.Framing``.

May import: hil.vocab, hil.wire, the pure standard library.

Tests may import too: device_profiles.
"""
