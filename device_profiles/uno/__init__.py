"""An Arduino Uno: it runs a compiled sketch, or hil's own with commands over its serial port, pulses by
Timer2.

``profile.yaml`` describes the board, ``board.py`` what hil asks it for. ``firmware.py`` says what runs when;
what a Uno shares with other boards that have a processor is in ``hil.firmware``. ``tool_watch.py`` sees a
tool while hil's own sketch runs. Of that ``step_dir_sketch.py`` is the main loop, ``typed_commands.py`` what
can be typed, ``stepping.py`` what they do. ``constants.py`` has what the sketch computes with, ``memory.py``
where it keeps that, ``ramp.py`` the pulses of a move. The native law ``pin_bank`` has the pins and the
processor.
"""
