"""Drive of CiA 402 (IEC 61800-7-201 and 301): what the objects from 6000h on mean, over the axis of a board.

``objects.py`` is the one table of objects; ``motor_axis.py`` says what a board's axis has to give.
Everything here is pure: simulated time is an argument, and the axis is moved through ``MotorAxis`` alone.

May import: bridges.can.canopen, hil.core, hil.firmware, hil.vocab, the pure standard library.

Tests may import too: bridges.can.frames, hil.wire.
"""
