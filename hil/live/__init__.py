"""A bench in real time: ports joined to devices, taps and real boards; memories, captures, guard and runs;
how it becomes what a configuration says.

May import: hil.compose, hil.config, hil.core, hil.firmware, hil.host, hil.net, hil.runs, hil.sim,
hil.telemetry, hil.vocab, hil.wire, the standard library.
"""
