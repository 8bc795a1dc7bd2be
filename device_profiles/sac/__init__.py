"""The SAC single-axis stepper controller.

``profile.yaml`` describes board, driver and motor, ``board.py`` what hil asks it for. ``firmware.py`` is its
program: ``terminal.py`` reads lines, ``network.py`` packets, and ``command_line.py`` executes both, with
``moves.py``, ``queue_memory.py`` and ``system_commands.py``. ``typed_text.py`` parses numbers and attributes;
``session.py`` and ``parameters.py`` hold what the board knows, ``eeprom.py`` keeps it, ``screens.py`` draws.
The pulses are made in the core (``native/motion``).

``path_planner.py`` plans commands for several boards that move together: ``straight_line.py`` lines,
``axis_commands.py`` what each axis gets, ``pulse_times.py`` when its pulses come.
"""
