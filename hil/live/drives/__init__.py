"""Real Modbus drives of a bench: their lines, their polls, what is written to them, and they as axes of runs.

``modbus_client.py`` is the one module that knows pymodbus; ``drive_line.py`` a place with one client, which
asks one thing after the other, ``drive_lines.py`` the lines that drives share; ``real_drive.py`` a drive,
``drive_polls.py`` its polls, ``drive_motion.py`` what moves it, ``drive_control.py`` its verbs,
``drive_axis.py`` the drive as an axis of runs; ``drive_axes.py`` all of a bench. What they decide is in
``hil.drives``, which knows no clock and no socket.
"""
