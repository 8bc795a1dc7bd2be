"""Doors of a bench in memory: bridges of its configuration, reached without sockets, in simulated time.

``bench_doors.py`` opens them when a test first asks, ``door_time.py`` is the time that passes for those who
wait for answers. A bridge gives its own part by ``in_memory`` of its ``bridge.py``: clients for tests.

May import: hil.compose, hil.config, hil.memory_desk, hil.sim, hil.testing.given, hil.vocab,
the standard library.
"""
