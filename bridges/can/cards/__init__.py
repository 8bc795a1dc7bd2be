"""CAN buses of a bench in simulated time: their taps, which are slcan adapters, and their nodes.

``bench_bus.py`` is a bus as the bench has it, ``can_tap.py`` an adapter with a client, ``channel_node.py``
the node of a channel, ``canopen_card.py`` the interface card of an axis.
What clients send is an input; a node is an input of nothing.

May import: bridges.can.bus, bridges.can.canopen, bridges.can.frames, hil.core, hil.sim, hil.vocab, hil.wire,
the pure standard library.
"""
