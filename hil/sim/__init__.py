"""A bench in simulated time: groups, devices, UARTs, stations of segments, inputs and their log, faults.

Deterministic: time is an argument, and nothing here looks at a clock or asks the operating system.

May import: hil.core, hil.firmware, hil.vocab, hil.wire, the pure standard library.
"""
