"""The master of a line without I/O and without a clock: whose turn it is, what was answered, what is known.

``line_turns.py`` has the turns on a half-duplex line, whatever is spoken there: one packet at a time, its
time-out, what may be repeated, and the outcome of each transaction. ``node_master.py`` speaks with nodes
that a profile describes (``hil.vocab.line_node``), ``line_run.py`` carries out phrases of commands for them.
Times are arguments, in nanoseconds of one clock that never goes back.

May import: hil.vocab, hil.wire, the pure standard library.

Tests may import too: device_profiles, hil.testing.
"""
