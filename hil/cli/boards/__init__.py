"""Commands of one board or one axis of a running bench: state, verbs, faults, drawings.

``board_access.py`` and ``axis_command.py`` command, ``type_command.py`` types at a port, ``motion_bar.py``
shows how far a motion is, ``draw_commands.py`` draws motion by ``drawn_recordings.py``,
``fault_commands.py`` spoils things.

May import: hil.cli.bench, hil.cli.framework, hil.host, hil.net, hil.telemetry, hil.vocab, hil.wire,
the standard library, typer.
"""
