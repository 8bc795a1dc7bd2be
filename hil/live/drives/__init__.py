"""Real drives of a bench: their lines and buses, what is asked of them, and they as axes of runs.

What all share: ``real_drive.py`` a drive, ``drive_motion.py`` what moves it, ``drive_control.py`` its verbs,
``drive_axis.py`` the drive as an axis of runs, ``shared_lines.py`` the lines of all, ``asking.py`` the
errors; ``hil.live.devices`` has all of a bench.

On Modbus: ``modbus_client.py`` is the one module that knows pymodbus; ``drive_line.py`` a place with one
client, which asks one thing after the other, ``drive_lines.py`` the lines that drives share;
``register_drive.py``, ``register_motion.py`` and ``register_control.py`` the drive, ``drive_polls.py`` its
polls.

On CAN: ``can_adapter.py`` is the one module that knows python-can; ``can_line.py`` a bus with its SYNC,
``sdo_dialogue.py`` what is read and written; ``can_drive.py``, ``can_motion.py`` and ``can_control.py`` the
drive, ``can_session.py`` how it is greeted and watched.

What they decide is in ``hil.drives``, which knows no clock and no socket.

May import: bridges.can, bridges.modbus.protocol, bridges.modbus.registers, hil.drives, hil.firmware,
hil.live.configured, hil.net, hil.runs, hil.vocab, hil.wire, the standard library, can, pymodbus.

Tests may import too: hil.config.
"""
