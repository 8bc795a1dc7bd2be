"""Services of Linux and systemd: real time, locked memory, files, signals, notification, the journal; and
what they refuse, why, and the line that mends it (``doctor.py``).

May import: hil.core, hil.vocab, the standard library.

Tests may import too: hil.net.
"""
