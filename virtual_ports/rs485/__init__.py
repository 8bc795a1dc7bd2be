"""RS485 segments: a wire that stations share, in simulated time.

May import: hil.vocab, hil.wire, the pure standard library.
"""
