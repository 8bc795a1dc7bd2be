"""CAN buses: wires that nodes share, in simulated time.

``can_bus.py`` is the bus and joins the wire's bits to the time of a clock, ``bus_nodes.py`` has its nodes and
tells them what happens on it, ``can_faults.py`` has the faults, ``bus_events.py`` what nodes and watchers are
told; ``native`` has the bits.

It knows frames, arbitration, errors and times; what a frame means it does not.

May import: bridges.can.frames, hil.vocab, hil.wire, the pure standard library.
"""
