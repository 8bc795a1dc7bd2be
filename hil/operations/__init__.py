"""Operations of a bench: the table of all (``table.py``), their permissions (``permissions.py``), and the
desk that carries them out (``desk.py``).

Each operation is carried out by one of the ``*_operations``, ``looking_on`` and ``reports``, which name the
parts that they need; health and metrics are readings of such parts. The control socket is a door as bridges
are: it has the desk and nothing else. The side that asks there is ``hil.net.control_client``.

May import: bridges.modbus.protocol, bridges.modbus.registers, hil.compose, hil.config, hil.core, hil.drives,
hil.firmware, hil.gcode, hil.host, hil.live, hil.net, hil.runs, hil.sim, hil.telemetry, hil.toolpath,
hil.vocab, hil.wire, the standard library.

Tests may import too: hil.client, hil.daemon, hil.testing.
"""
