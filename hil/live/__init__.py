"""A bench in real time: ports joined to devices, taps and real boards.

Belongs here: how the bench becomes what the configuration says, at the start and at a reload (``apply``),
where bytes enter and leave (``places.py``, ``port_link.py``), and what needs the wall's time or the
operating system while the boards run: memories (``store.py``), captures, ``runs``, real ``drives``, the guard
over firmware, the core's thread. ``live_bench.py`` composes it.

May import: hil.compose, hil.config,
hil.core, hil.drives, hil.firmware, hil.gdb, hil.host, hil.instruments, hil.net, hil.runs, hil.sim,
hil.sketch, hil.telemetry, hil.vocab, hil.wire, the standard library, can, pymodbus.

Tests may import too: bridges.can.frames, hil.daemon, hil.testing.
"""
