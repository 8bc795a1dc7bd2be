"""Real drives on CAN: their buses, what is asked of them, and how they are greeted and watched.

``can_drive_address.py`` reads the address of one. ``can_adapter.py`` is the one module that knows python-can;
``can_line.py`` is a bus with its SYNC, ``sdo_dialogue.py`` what is read and written; ``can_drive.py``,
``can_motion.py``, ``can_steps.py`` and ``can_control.py`` are the drive, ``can_session.py`` greets and
watches it. What they decide is in ``bridges.can.canopen.master``.

May import: bridges.can.canopen, bridges.can.frames, hil.drives, hil.firmware, hil.vocab, hil.wire,
the standard library, can.
"""
