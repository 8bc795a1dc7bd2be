"""Services of Linux and systemd: real time, locked memory, files, signals, notification, the journal; and
what they refuse, why, and the line that mends it (``doctor.py``).

Imports ``hil.vocab`` alone.
"""
