"""Library that profiles are written against: the runtime of main programs, the serial interface's
receive buffer, the Arduino print and parse formats, the file format of a board's non-volatile memory, paths
of set-points, servo drives with a closed loop, steps of dialogues, the program of a board that has none.

Everything here is pure: bytes and simulated time come in as arguments or as answers to a ``yield``.

May import: hil.vocab, hil.wire, the pure standard library.
"""
