"""CANopen: the tables that all sides of it share, and a folder for each side.

``sdo_frames.py`` builds SDO frames and takes them apart, ``abort_codes.py`` says why a transfer ends;
``can_ids.py`` has identifiers, ``canopen_codes.py`` codes of network management and emergencies,
``cia402_words.py`` the states, words and modes of drives. ``node`` is a device on the bus, ``cia402`` its
profile of drives, ``master`` asks real drives, ``words`` says what is on the wire.

Source: CiA 301 version 4.2.0; CiA 402-2 for drives.

May import: bridges.can.frames, hil.core, hil.drives, hil.firmware, hil.vocab, hil.wire,
the pure standard library.
"""
