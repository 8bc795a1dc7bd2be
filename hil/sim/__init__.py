"""A bench in simulated time. Deterministic: time is an argument, and nothing here looks at a clock or asks
the operating system.

``bench.py`` composes it and gives each input its one time; ``group.py`` advances what shares a time;
``twin.py`` is a board, ``uart.py`` its serial interface, ``segment_tap.py`` a tap.
``inputs.py`` has the inputs from outside, ``input_log.py`` their log, ``faults`` the faults.

May import: hil.core, hil.firmware, hil.sketch, hil.vocab, hil.wire, the pure standard library.

Tests may import too: hil.live, hil.testing.
"""
