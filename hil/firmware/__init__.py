"""What a profile's firmware is written against: the serial interface's receive buffer, the Arduino
print and parse formats, and the file format of a board's non-volatile memory.

Everything here is pure: bytes and simulated time come in as arguments or as answers to a ``yield``.

May import: hil.vocab, hil.wire, the pure standard library.
"""
