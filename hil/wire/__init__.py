"""Bytes and frames on a wire, with no I/O: what a receiver makes of a signal, how long characters
take, checksums and packet codecs; JSON that comes from outside.

Everything here is pure: times are arguments or offsets in nanoseconds.

May import: hil.vocab, the pure standard library.
"""
