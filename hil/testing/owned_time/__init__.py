"""A whole program on the simulated time of a bench: its threads, locks, clocks and ports, in a process of its
own.

``turns.py`` lets one thread run at a time, each by its ``thread_turn.py``, and time pass when all wait.
``owned_locks.py``, ``threads.py``, ``clocks.py``, ``file_times.py``, ``listed_ports.py``, ``selecting.py``,
``owned_signals.py`` and ``children.py`` are what the program has in place of what Python has;
``put_in_place.py`` puts them there. ``program.py`` runs a program so. ``child_start.py`` begins its children.

May import: hil.config, hil.sim, hil.testing.bench, hil.testing.input_lines,
hil.testing.seeds.late_arrivals, hil.testing.serial_ports, hil.vocab, the standard library, serial.

Tests may import too: hil.testing.
"""
