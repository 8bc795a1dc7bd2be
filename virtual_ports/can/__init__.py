"""CAN buses: wires that nodes share, in simulated time.

``can_bus.py`` is the bus, ``bus_node.py`` a node of it, ``bus_line.py`` joins the wire's bits to the time of
a clock; ``_bit_wire.pyx`` has the bits.

It knows frames, arbitration, errors and times; what a frame means it does not.

May import: hil.vocab, hil.wire, the pure standard library.
"""
