"""An Arduino Uno with a step/dir sketch: commands over its serial port, pulses by Timer2.

``profile.yaml`` describes the board, ``board.py`` what hil asks it for. ``firmware.py`` is the sketch's main
loop, ``typed_commands.py`` what can be typed, ``stepping.py`` what they do. ``constants.py`` has what the
sketch computes with, ``memory.py`` where it keeps that, ``ramp.py`` the pulses of a move. The native law
``pin_bank`` has the pins.
"""
