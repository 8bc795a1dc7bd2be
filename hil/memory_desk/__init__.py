"""Desk of a bench in memory, for doors that are opened there without sockets.

``door_loop.py`` is the event loop in which a door's tasks run on simulated time; ``desk_in_memory.py`` puts
the parts that answer a daemon's requests around a bench that has no daemon.

May import: hil.config, hil.host.real_time, hil.live, hil.operations, hil.sim, hil.telemetry, hil.vocab,
the standard library.

Tests may import too: hil.testing.
"""
