"""Registers of an axis: what doors and nodes of Modbus show of a device, and how they are written.

``layout.py`` has the numbers of the blocks, ``cells.py`` values in registers, also those written in parts,
``register_map.py`` the map of a device, made of its fields and verbs alone, with the control word
and what verbs take,
``register_unit.py`` a unit with its state, of which ``axis_registers.py`` tells the axis.
``map_rows.py`` has the map for people and programs.
``drive_map.py`` is a drive's own map, as its maker has it, ``drive_cells.py`` what is where in it,
``drive_unit.py`` a unit with it; ``units.py`` makes the unit of any device. What a node on a line needs of a
unit is in ``registers_protocol.py``, with what a unit is and why it refuses. Nothing here asks a bench: a
unit answers what has to be done.

May import: bridges.modbus.protocol, hil.vocab, the pure standard library.
"""
