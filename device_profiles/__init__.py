"""Kinds of boards, one folder each: its description (``profile.yaml``), what hil asks it for
(``PROFILE`` in ``board.py``), firmware and transcripts.

A profile is found by its folder's name when a configuration names it; there is no list to enter it in.
Simulated time is an argument.

Each may import: hil.firmware, hil.sketch, hil.vocab, hil.wire, the pure standard library, pathlib, typer.

Tests may import too: bridges.modbus.protocol, hil.compose, hil.core, hil.sim, hil.testing.
"""
