"""The command ``hil``: its commands, their drawings, its completion, its man page and the reference.

Belongs here: what a user types and reads. ``entry.py`` is where the program begins, ``command_table.py`` says
where each command is, ``command_group.py`` makes the command line of it, ``ask.py`` has what those share that
ask a running bench. A command imports other rooms when it runs: each starts quickly. No other room imports
this one.

May import: bridges.can, bridges.modbus.maps, bridges.modbus.protocol, bridges.modbus.registers,
hil.arduino, hil.compose,
hil.config, hil.core, hil.daemon, hil.discovery, hil.drives, hil.firmware, hil.gcode, hil.host, hil.live,
hil.master, hil.net, hil.operations, hil.runs, hil.sim, hil.telemetry, hil.testing, hil.toolpath, hil.vocab,
hil.wire, the standard library, can, rich, serial, typer.
"""
