"""Chance of benches in memory, all of it drawn from one seed.

``bench_chance.py`` has the seeds of a bench's faults and axes; ``late_arrivals.py`` the bytes that come some
time after they were written.

May import: hil.config, hil.sim, hil.vocab, the standard library.

Tests may import too: device_profiles, hil.compose, hil.testing.
"""
