"""Faults of twins, segments, buses and taps: each begins and ends in simulated time, and is in the input log.

Faults in force are those listed, in whatever order they begin and end. So no fault remembers what was before
it. Those with a state of their own (the chance of a byte fault) act under their numbers. The effects of
several on one thing (a coil, the supply, a board's power) are computed again from all that are in force.

May import: hil.core, hil.sim, hil.vocab, hil.wire, the pure standard library.
"""
