"""Master of real CANopen drives of CiA 402, without I/O: what is asked of one, in which order, and what its
answers and its frames mean.

``sdo_transfer.py`` reads or writes an object; ``drive_units.py`` says what its numbers mean,
``process_data.py`` what its PDOs carry, ``greeting.py`` all that is asked when it comes to be there;
``node_watch.py`` says when it is lost. Times are arguments.

Sources: CiA 301 V4.2.0, CANopen application layer and communication profile; CiA 402-2 V3.0 and V4.0, drives
and motion control, operation modes and application data.

May import: bridges.can.canopen, bridges.can.frames, hil.drives, hil.vocab, hil.wire,
the pure standard library.
"""
