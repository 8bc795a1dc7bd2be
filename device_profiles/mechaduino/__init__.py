"""The Mechaduino closed-loop stepper servo with firmware 0.1.5.

``profile.yaml`` describes the board, its motor and encoder, ``board.py`` what hil asks it for.
``firmware.py`` is its program, with ``encoder.py``, ``lookup_table.py``, ``calibration.py`` (which makes the
table), ``routines.py`` and ``menus.py``; ``serial_usb.py`` prints and waits, ``text.py`` has what is printed.
"""
