"""Modbus door of a bench in memory, and clients of pymodbus at it, for the test kit.

``memory_door.py`` opens the door without sockets, ``memory_connection.py`` is a connection to it;
``bench_clients.py`` are the clients.

May import: bridges.modbus, hil.net.endpoint, hil.net.fair_share, hil.testing.doors, hil.testing.given,
hil.vocab, the standard library, pymodbus.

Tests may import too: hil.compose, hil.memory_desk, hil.testing.
"""
