"""Bytes and frames on a wire, with no I/O: character times, receivers, byte faults, captures, pulse trains,
names of serial ports; Modbus; CAN frames and slcan; JSON that comes from outside.

Everything here is pure: times are arguments or offsets in nanoseconds.

May import: hil.vocab, the pure standard library.

Tests may import too: bridges.modbus.protocol, hil.testing.
"""
