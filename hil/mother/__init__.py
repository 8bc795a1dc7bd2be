"""The master of a line: commands and watches all nodes of a segment, virtual or real.

``turns`` has what a master decides, without I/O. Beside it is what carries bytes and looks at the clock.

May import: hil.discovery, hil.net, hil.vocab, hil.wire, the standard library, serial.

Tests may import too: device_profiles, hil.testing.
"""
