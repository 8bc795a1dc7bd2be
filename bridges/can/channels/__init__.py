"""Channels of CAN: programs with python-can, in this process, on this computer or in its network, and CAN
interfaces of Linux are joined to a bench's simulated bus.

``channel_options.py`` says how; ``bus_channel.py`` is one, a node of the bus; ``udp_medium.py`` and
``python_can_medium.py`` are what its programs share. Frames go either way, each with its simulated time;
errors stay on their side, as with any controller.

May import: bridges.can.bus, bridges.can.frames, hil.vocab, the standard library, any package.

Tests may import too: bridges.can.bridge.
"""
