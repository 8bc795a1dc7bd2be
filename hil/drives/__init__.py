"""Real drives as axes, without I/O: what is read of them, what it means, what is written for a verb, when a
drive is lost, and when its motion has ended.

``drive_link.py`` says when it is there, ``arrival.py`` when it has come to its target, ``drive_fields.py``
what doors see of it, ``drive_verbs.py`` what can be asked of it. Of a drive on Modbus ``poll_plan.py`` says
what is read and what a reading means, ``control_bits.py`` which words switch its bits; those on CAN are in
``canopen``. ``hil.live.drives`` carries this out.

May import: bridges.modbus.protocol, bridges.modbus.registers, hil.core, hil.vocab, hil.wire,
the pure standard library.

Tests may import too: hil.config.
"""
