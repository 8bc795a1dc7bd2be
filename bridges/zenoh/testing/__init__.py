"""Zenoh door of a bench in memory, and a session at it, for the test kit.

``memory_zenoh_door.py`` has the bridge answer without a network, ``memory_network.py`` carries what sessions
say to each other, ``memory_session.py`` is a session, ``memory_messages.py`` has samples, queries, replies
and the channels in which they come.

May import: bridges.zenoh, hil.testing.doors, hil.vocab, the standard library, zenoh.

Tests may import too: hil.testing.
"""
