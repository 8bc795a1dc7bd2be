"""Ports of a bench in memory as pyserial's ``Serial``, on simulated time.

pyserial's own code runs, with all its habits; what it asks of the system is answered here. ``line_ends.py``
is the client's end of a line, with the times at which bytes are there; ``port_terminal.py`` what Linux makes
of it: buffers, speeds, locks; ``system_calls.py`` the calls that pyserial makes, with ``port_requests.py``
for requests and ``port_lines.py`` for modem lines; ``bench_serial.py`` the class; ``ports_of_bench.py`` has
all ports of a bench; ``protocol_hil.py`` finds one by its URL, also among the ``open_benches.py``.
``passing.py`` lets simulated time pass while a test's only thread waits.

May import: hil.config, hil.net, hil.sim, hil.testing.given, hil.vocab, the standard library, serial.

Tests may import too: device_profiles, hil.testing.
"""
