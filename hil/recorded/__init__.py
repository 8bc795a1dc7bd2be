"""Runs that were recorded: gone through again on the virtual clock, and looked at.

Belongs here: what answers a question about a run from its input log (``recorded_run.py``): samples of its
axes (``sampled.py``), and names of fields and times as people write them (``recorded_fields.py``,
``time_words.py``); and what its lines say without a replay (``said_lines.py``). Nothing here asks a clock.

May import: hil.compose, hil.config, hil.core, hil.discovery, hil.host, hil.net, hil.sim, hil.telemetry,
hil.vocab, hil.wire, the standard library, mcap, vcd, zstandard.

Tests may import too: hil.testing.
"""
