"""Paths of a machine: canonical motions to what its boards do, checked and planned before anything moves.

``machine.py`` reads a machine's document. ``motion_check.py`` compares a program with it and makes stretches
of straight pieces (``path_items.py``); ``path_speeds.py`` has their speeds, and ``path_plan.py`` the
whole. ``node_phrases.py`` makes commands of it for the nodes of a line, ``line_load.py``
calculates whether that line keeps up, and ``deviation.py`` compares what was followed with what was asked.

Pure: no clock, no line, no file.

May import: hil.config, hil.core, hil.gcode, hil.runs, hil.vocab, the pure standard library, pydantic.

Tests may import too: device_profiles, hil.discovery, hil.firmware, hil.testing.
"""
