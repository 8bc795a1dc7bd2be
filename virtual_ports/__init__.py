"""Ports, where bytes enter: one folder for each kind, found by its name when a configuration names it.

Each folder has a ``port.py`` with ``Options`` (a strict pydantic model) and
``make(options, context) -> Port``; ``rs485``, a wire for many stations, has a ``segment.py`` instead. A port
knows no device and no simulated time.

Each may import: hil.net, hil.vocab, hil.wire, the standard library, any package.

Tests may import too: bridges.modbus.protocol, hil.testing.
"""
