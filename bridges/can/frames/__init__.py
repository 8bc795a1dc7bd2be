"""CAN frames: their values, their bits on the wire, their lengths; and Lawicel's ASCII protocol of adapters.

``can_frame.py`` has the frame, ``frame_length.py`` its length, ``slcan.py`` the adapter's side of a serial
line. Bits are 0 (dominant) and 1 (recessive).

Source: Robert Bosch GmbH, CAN Specification 2.0, 1991, part B; ISO 11898-1:2015 for what it leaves open.

May import: hil.vocab, hil.wire.outside_text, the pure standard library.

Tests may import too: hil.wire.
"""
