"""Real Modbus drives as axes, without I/O: which registers are read together, what they mean, what is written
for a verb, when a drive is lost, and when its motion has ended.

``poll_plan.py`` says what is read and what a reading means, ``control_bits.py`` which words switch its bits,
``drive_link.py`` when it is there, ``arrival.py`` when it has come to its target, ``drive_fields.py`` what
doors see of it, ``drive_verbs.py`` what can be asked of it. ``hil.live.drives`` carries this out.

May import: hil.core, hil.registers, hil.vocab, hil.wire, the pure standard library.

Tests may import too: hil.config.
"""
