"""Walter's Cortex: controller of an arm with seven axes, five geared steppers and two servos.

``profile.yaml`` describes board and joints, ``board.py`` what hil asks it for. ``firmware.py`` is its
program: ``cortex_commands.py`` reads lines with ``command_text.py``, ``controller.py`` moves the arm, with
``servo_drive.py`` and ``servo_packets.py``; ``board_loop.py`` is its face to the main loop, which the core
runs (``native/law/walter``). ``settings.py`` and ``late_save.py`` keep what is set, ``logger.py``,
``thermal_printer.py`` and ``lights.py`` tell, ``sessions.py`` reads recordings.
"""
