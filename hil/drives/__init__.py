"""Real drives of a bench as devices and as axes of runs, whatever bus they are on.

Without I/O: ``drive_link.py`` says when one is there and what it told, ``drive_fields.py`` what doors see
of it and what can be asked of it.

With I/O: ``real_drive.py`` is a drive, ``drive_motion.py`` moves it and says when it has come to its target,
``drive_control.py`` has its verbs, ``drive_axis.py`` is the drive as an axis of runs. Each bus has its own
kind of each.

May import: hil.core, hil.firmware, hil.runs, hil.vocab, hil.wire, the standard library.
"""
