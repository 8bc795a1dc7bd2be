"""Door of a bench for Modbus: axes as units of Modbus TCP, with or without TLS, and of serial lines.

``modbus_bridge.py`` opens the door, ``door_options.py`` says how; ``request_handler.py`` knows which
unit is which axis, carries requests out at the desk and awaits the ends of motions,
``tcp_client.py`` lets clients in and answers one when ``hil.net.fair_share`` says so,
``client_role.py`` reads certificates, ``certificate_files.py`` the door's own; ``rtu_server.py`` has a
serial line. ``cycle_command.py`` says how long a master's cycle takes.

May import: bridges.modbus.protocol, bridges.modbus.registers, bridges.modbus.unit_transaction, hil.net,
hil.vocab, hil.wire, the standard library, any package.

Tests may import too: bridges.modbus.bridge, bridges.modbus.cli.
"""
