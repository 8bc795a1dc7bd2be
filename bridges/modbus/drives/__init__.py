"""Real drives on Modbus: what is read and written by a map, and their lines.

Without I/O: ``modbus_drive_address.py`` reads the address of one, ``poll_plan.py`` says what is read and
what a reading means, ``control_bits.py`` which words switch its bits.

With I/O: ``modbus_client.py`` is the one module that knows pymodbus; ``drive_line.py`` a place with one
client, which asks one thing after the other, ``drive_lines.py`` the lines that drives share;
``register_drive.py``, ``register_motion.py`` and ``register_control.py`` are the drive, ``drive_polls.py``
its polls. ``map_orders.py`` has the writes of commands by a map of version 2, ``map_control.py`` a drive with
such a map.

May import: bridges.modbus.protocol, bridges.modbus.registers, hil.drives, hil.firmware, hil.net, hil.vocab,
hil.wire, the standard library, pymodbus.

Tests may import too: bridges.modbus.maps, hil.core.
"""
