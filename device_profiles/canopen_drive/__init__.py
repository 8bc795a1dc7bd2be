"""A closed-loop servo drive on a CAN bus: a twin whose node of CiA 402 the bench makes, or a real one.

``profile.yaml`` describes drive and motor, ``board.py`` what hil asks it for, ``firmware.py`` its program:
the loop, the ramps, the faults; ``verbs.py`` the requests of everybody. The state machine of CiA 402 is not
here: it is the node's.
"""
