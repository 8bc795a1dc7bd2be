"""GDB's remote serial protocol for a simulated AVR, with no I/O: bytes come in, bytes and calls at the chip
go out.

``remote_packets.py`` has packets and their acknowledgements, ``avr_target.py`` GDB's numbers of registers and
addresses for an AVR and what a session asks of a chip. ``run_control.py`` lets it run and step, and
``debug_session.py`` has the dialogue.

Source: "GDB Remote Serial Protocol", appendix E of "Debugging with GDB" for GDB 12.

May import: the pure standard library.
"""
