"""A bench in simulated time. Deterministic: time is an argument, and nothing here looks at a clock or asks
the operating system.

``bench.py`` has it all and gives each input its one time; ``group.py`` advances what shares a time;
``device.py`` is a board, ``uart.py`` its serial interface, ``segment_tap.py`` a tap. ``inputs.py`` is what
can happen to them, ``input_log.py`` how it is kept, ``faults`` what goes wrong.

May import: hil.core, hil.firmware, hil.vocab, hil.wire, the pure standard library.
"""
