"""Library that profiles are written against.

It has the runtime of main programs, the serial interface's receive buffer, the Arduino print and parse
formats, and the file format of a board's non-volatile memory. It also has paths of set-points, servo drives
with a closed loop, steps of dialogues, the program of a board that has none, and that of one with a processor
for a user's program (``programmed_board.py``, with ``bootloader.py`` and ``chip_memory.py``).

Everything here is pure: bytes and simulated time come in as arguments or as answers to a ``yield``.

May import: hil.sketch, hil.vocab, hil.wire, the pure standard library, inspect, sys.
"""
