"""A bench in real time: ports joined to devices, taps and real boards; memories, captures, guard and runs;
how it becomes what a configuration says.

Imports what builds and simulates a bench (``hil.compose`` and below), ``hil.host`` and ``hil.net``.
"""
