"""The command ``hil``: its commands, their drawings, its completion, its man page and the reference.

Belongs here: what a user types and reads. ``entry.py`` is where the program begins. ``framework`` makes the
command line of its table and has what commands share, ``documents`` has what is written from it; each other
folder has the commands about one thing. A command imports other rooms when it runs: each starts quickly. No
other room imports this one.

May import: hil.arduino, hil.client, hil.compose, hil.config, hil.core, hil.daemon, hil.discovery, hil.drives,
hil.firmware, hil.gcode, hil.gdb, hil.host, hil.instruments, hil.live, hil.master, hil.net, hil.operations,
hil.recorded, hil.runs, hil.sim, hil.sketch, hil.telemetry, hil.testing, hil.toolchain, hil.toolpath,
hil.vocab, hil.wire, the standard library, cryptography, rich, serial, typer.

Tests may import too: bridges.can.frames, bridges.modbus.protocol.
"""
