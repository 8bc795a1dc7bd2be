"""A closed-loop servo drive that is spoken to by Modbus, at registers that a map says.

``profile.yaml`` describes drive and motor and has the map that is built in, ``board.py`` what hil asks it
for. ``firmware.py`` is its program: the loop, the ramps, the faults. ``registers.py`` has what a master
writes, ``verbs.py`` the requests of everybody else; both lead to the same set-point.
"""
