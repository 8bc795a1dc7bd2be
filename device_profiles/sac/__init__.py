"""The SAC single-axis stepper controller.

``profile.yaml`` describes board, driver and motor; ``firmware.py`` is its program: ``line.py`` reads
numbers and motion commands, ``eeprom.py`` keeps parameters and queue, ``screens.py`` draws. The pulses are
made in the core (``native/motion``). May import ``hil.vocab``, ``hil.wire`` and ``hil.firmware``.
"""
