"""The SAC single-axis stepper controller.

``profile.yaml`` describes board, driver and motor. ``firmware.py`` is its program: ``terminal.py`` has lines,
``line.py`` reads numbers and motion commands, ``moves.py`` and ``queue_memory.py`` do what they say,
``session.py`` and ``parameters.py`` hold what the board knows, ``eeprom.py`` keeps it, ``screens.py`` draws.
The pulses are made in the core (``native/motion``).
"""
