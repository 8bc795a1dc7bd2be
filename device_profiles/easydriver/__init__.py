"""The EasyDriver: a board with an Allegro A3967 that turns a stepper by pulses at its pins.

``profile.yaml`` describes driver and motor, ``board.py`` what hil asks it for. The native law ``a3967`` has
its pins, its translator and its heat. ``reversal.py`` has the speed that the coils allow.
"""
