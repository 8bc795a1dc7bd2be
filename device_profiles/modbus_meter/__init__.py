"""A board without a motor that is spoken to by Modbus, at cells that a map says: meters, sensors, displays.

``profile.yaml`` describes it and has the map that is built in, ``board.py`` what hil asks it for.
``firmware.py`` is its program, which keeps the cells, stores some, and moves values on ramps.
"""
