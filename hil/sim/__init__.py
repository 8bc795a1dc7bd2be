"""A bench in simulated time: groups, devices, UARTs, stations of segments, inputs and their log, faults.

Deterministic: time is an argument, and nothing here looks at a clock or asks the operating system. Imports
``hil.vocab``, ``hil.wire``, ``hil.firmware`` and ``hil.core``; never a profile or a kind of port.
"""
